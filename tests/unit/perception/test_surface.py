"""Lifting a frame: every pixel's world point projects back onto the pixel."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from surefetch.common.geometry import Array, intrinsics, inverse, look_at, project, transform
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.perception.surface import filled, lift, rays_of

H, W = 240, 320


def table_frame(T: Array | None, hole: bool = False) -> RgbdFrame:
    """A bare table seen from a fixed place, with or without a pose and a hole in the depth."""
    K = intrinsics(W, H, 50.0)
    pose = look_at(np.array([-0.5, 0.0, 0.45]), np.zeros(3), np.array([0.0, 0.0, 1.0]))
    rays = rays_of(K, H, W) @ pose[:3, :3].T
    depth = (-pose[2, 3] / rays[..., 2]).astype(np.float32)
    depth[depth < 0] = 0
    if hole:
        depth[80:140, 120:200] = 0
    rgb = np.full((H, W, 3), 120, np.uint8)
    return RgbdFrame(rgb, depth, K, pose if T is not None else None)


@pytest.mark.parametrize("hole", [False, True])
@pytest.mark.parametrize("T", [None, np.eye(4)])
def test_points_project_back_onto_their_pixels(T: Array | None, hole: bool) -> None:
    frame = table_frame(T, hole)
    surface = lift(frame)
    assert surface is not None
    rows, columns = np.nonzero(surface.valid)
    points = transform(
        inverse(surface.T_world_camera), surface.points_world_m[rows, columns].astype(np.float64)
    )
    pixels = np.column_stack([columns, rows])
    assert np.abs(project(frame.K, points) - pixels).max() < 0.01
    assert np.abs(surface.height_m[surface.measured]).max() < 0.003
    assert (surface.height_m[~surface.valid] == -1).all()


def test_a_large_hole_in_the_depth_stays_missing() -> None:
    surface = lift(table_frame(None, hole=True))
    assert surface is not None
    assert not surface.valid[108, 160]


def test_without_depth_there_is_no_surface() -> None:
    frame = table_frame(None)
    empty = RgbdFrame(frame.rgb, np.zeros((H, W), np.float32), frame.K, None)
    assert lift(empty) is None


def test_not_a_number_counts_as_missing() -> None:
    frame = table_frame(None)
    depth = frame.depth_m.copy()
    depth[::3, ::3] = np.nan
    depth[1, 1], depth[2, 2] = np.inf, -0.4
    surface = lift(RgbdFrame(frame.rgb, depth, frame.K, None))
    assert surface is not None
    assert np.isfinite(surface.points_world_m).all()
    assert np.isfinite(surface.height_m).all()
    assert not surface.measured[::3, ::3].any()


def images() -> st.SearchStrategy[NDArray[np.float32]]:
    return hnp.arrays(np.float32, (9, 9), elements=st.sampled_from([0.0, 0.5, 0.75, 1.0]))


@settings(deadline=None)
@given(images())
def test_filling_keeps_what_was_measured_and_invents_no_depth(depth: NDArray[np.float32]) -> None:
    rgb = np.full((9, 9, 3), 90, np.uint8)
    out = filled(depth, rgb)
    assert np.array_equal(out[depth > 0], depth[depth > 0])
    assert set(np.unique(out)) <= set(np.unique(depth)) | {np.float32(0.0)}


def test_a_hole_takes_the_depth_of_the_side_whose_colour_it_has() -> None:
    depth = np.full((9, 10), 1.0, np.float32)
    depth[:, :5] = 0.5
    rgb = np.full((9, 10, 3), 200, np.uint8)
    rgb[:, :5] = 20
    depth[:, 4:6] = 0
    out = filled(depth, rgb)
    assert (out[:, 4] == 0.5).all()
    assert (out[:, 5] == 1.0).all()
