"""Cubes are told from blocks by what is seen beside and behind them, and by nothing else."""

from dataclasses import dataclass

import numpy as np
import pytest

from surefetch.common.geometry import Array, intrinsics, look_at
from surefetch.common.mask import Bits
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.perception.answers import boxes, faces
from surefetch.perception.answers.boxes import cube_or_block
from surefetch.perception.answers.see_through import Window, rays_of
from surefetch.perception.solids import Solid
from surefetch.perception.surface import Surface, lift

WIDTH, HEIGHT = 320, 240
K = intrinsics(WIDTH, HEIGHT, 30.0)
EYE = np.array([-0.53, 0.0, 0.40])
T = look_at(EYE, np.array([0.0, 0.0, 0.02]), np.array([0.0, 0.0, 1.0]))
CUBE = Solid("box", 0.0, 0.0, 0.2, (0.05, 0.05), 0.0, 0.05, 0.3)
BLOCK = Solid("box", 0.0, 0.0, 0.2, (0.04, 0.07), 0.0, 0.04, 0.3)
SCREEN = Solid("box", -0.10, 0.075, 0.0, (0.012, 0.15), 0.0, 0.16, 0.3)
"""It hides the left half."""


@dataclass(frozen=True, eq=False)
class Scene:
    surface: Surface
    bits: Bits
    """Of the first solid"""


def scene(*solids: Solid) -> Scene:
    """A table with solids, by rays; no noise."""
    rows, columns = np.indices((HEIGHT, WIDTH)).reshape(2, -1)
    camera = np.column_stack(
        [(columns - K[0, 2]) / K[0, 0], (rows - K[1, 2]) / K[1, 1], np.ones(rows.size)]
    )
    rays: Array = camera @ T[:3, :3].T
    length = np.linalg.norm(rays, axis=1)
    nearest = np.where(rays[:, 2] < -1e-6, -EYE[2] / rays[:, 2], 9.0)
    which = np.full(rows.size, -1)
    for k, solid in enumerate(solids):
        laid = faces.lay(solid, rays, EYE)
        depth = np.where(laid.met, laid.distance_m / length, np.inf)
        which, nearest = np.where(depth < nearest, k, which), np.minimum(nearest, depth)
    depth_m = np.where(nearest < 3.0, nearest, 0.0).reshape(HEIGHT, WIDTH).astype(np.float32)
    rgb = np.full((HEIGHT, WIDTH, 3), 120, dtype=np.uint8)
    rgb.reshape(-1, 3)[which >= 0] = (40, 160, 60)
    surface = lift(RgbdFrame(rgb, depth_m, K, T))
    assert surface is not None
    return Scene(surface, np.asarray((which == 0).reshape(HEIGHT, WIDTH)))


def test_the_rays_of_pixels_meet_what_they_show() -> None:
    seen = scene(CUBE)
    rows, columns = np.nonzero(seen.bits)
    assert faces.lay(CUBE, rays_of(seen.surface, rows, columns), EYE).met.mean() > 0.98


@pytest.mark.parametrize("solid", [CUBE, BLOCK], ids=["cube", "block"])
def test_a_box_in_full_view_is_what_it_is(solid: Solid) -> None:
    seen = scene(solid)
    found = cube_or_block(Window(seen.surface, seen.bits), solid)
    right, wrong = found.against_cube_px, found.against_block_px
    if solid is BLOCK:
        right, wrong = wrong, right
    n_px = np.count_nonzero(seen.bits)
    assert right < 0.01 * n_px
    assert wrong > 0.1 * n_px


def test_what_a_screen_hides_may_be_long() -> None:
    half = Solid("box", 0.0, -0.0125, 0.0, (0.05, 0.025), 0.0, 0.05, 0.3)
    seen = scene(Solid("box", 0.0, 0.0, 0.0, (0.05, 0.05), 0.0, 0.05, 0.3), SCREEN)
    found = cube_or_block(Window(seen.surface, seen.bits), half)
    assert found.against_cube_px < 10.0
    assert found.against_block_px < 10.0


def test_longer_boxes_are_possible_only_behind_an_occluder() -> None:
    cube = Solid("box", 0.0, 0.0, 0.0, (0.05, 0.05), 0.0, 0.05, 0.3)
    free, hidden = scene(cube), scene(cube, SCREEN)
    assert boxes.possible(Window(free.surface, free.bits), cube) == [cube]
    longer = boxes.possible(Window(hidden.surface, hidden.bits), cube)
    assert len(longer) > 1
    assert all(one.y_m >= cube.y_m for one in longer), "it may only go on behind the screen"
