"""What the classical back-end sees of simulated tables, against the truth about every pixel."""

import msgspec
import numpy as np
import pytest
from rendered import Shot, perceive, shoot
from tabletop import WHITE, body, box, scene

from surefetch.common.geometry import Array, look_at
from surefetch.common.mask import iou
from surefetch.common.messages import Body, Marking, Rgb, Scene, Screen, Target
from surefetch.perception.candidate import Candidate
from surefetch.perception.observe import Perceived
from surefetch.perception.reply import container_reading, cover

BLACK = (0.08, 0.08, 0.09)
CROWD: tuple[Body, ...] = (
    body("cube", "cube", (0.045, 0.045, 0.045), (0.84, -0.18)),
    body("ball", "ball", (0.05, 0.05, 0.048), (0.83, 0.17)),
    body("cylinder", "cylinder", (0.04, 0.04, 0.08), (0.98, 0.0)),
    body("prism", "hexagonal prism", (0.04, 0.0462, 0.06), (1.05, 0.08)),
    body("block", "block", (0.035, 0.07, 0.03), (0.80, 0.02)),
)


def painted(one: Body, rgb: Rgb) -> Body:
    return msgspec.structs.replace(one, rgb=rgb)


def of_body(perceived: Perceived, shot: Shot, index: int) -> tuple[float, Candidate]:
    """The candidate that shows a body, and how well its mask fits."""
    truth = shot.pixels_of(index)
    overlaps = [iou(candidate.bits, truth) for candidate in perceived.scene.candidates]
    best = int(np.argmax(overlaps))
    return overlaps[best], perceived.scene.candidates[best]


@pytest.mark.parametrize("view", ["center", "right", "close_high"])
@pytest.mark.parametrize("rgb", [None, BLACK, WHITE])
def test_every_body_is_found_and_outlined(view: str, rgb: Rgb | None) -> None:
    bodies = CROWD if rgb is None else tuple(painted(one, rgb) for one in CROWD)
    shot = shoot(scene(*bodies, container=box(covered=False)), view)
    perceived = perceive(shot.frame)
    shown = [k for k in range(len(bodies)) if shot.pixels_of(k).sum() >= 100]
    assert len(perceived.scene.candidates) == len(shown)
    for k in shown:
        overlap, candidate = of_body(perceived, shot, k)
        assert overlap > 0.85
        assert candidate.center_world_m is not None
        off = np.subtract(candidate.center_world_m[:2], bodies[k].position_world_m[:2])
        assert np.hypot(*off) < (0.012 if candidate.occluded_share > 0.2 else 0.005)
        assert candidate.on_container_floor == (k in (2, 3))


@pytest.mark.parametrize("view", ["center", "right", "close_high"])
def test_the_container_is_measured_to_millimetres(view: str) -> None:
    truth = box(covered=False)
    shot = shoot(scene(*CROWD, container=truth), view)
    found = container_reading(perceive(shot.frame).scene)
    assert found is not None
    assert np.hypot(*np.subtract(found.outer.center_world_m[:2], (1.02, 0.03))) < 0.002
    assert sorted(found.inner_size_m) == pytest.approx(sorted(truth.inner_size_m), abs=0.004)
    assert found.rim_z_m == pytest.approx(truth.wall_height_m, abs=0.002)
    assert found.floor_z_m == pytest.approx(truth.floor_thickness_m, abs=0.002)
    assert found.complete
    assert found.lid is None


@pytest.mark.parametrize("view", ["center", "right", "close_high"])
def test_a_lid_is_seen_with_its_knob(view: str) -> None:
    shot = shoot(scene(CROWD[0], container=box(covered=True)), view)
    perceived = perceive(shot.frame)
    assert cover(perceived.scene) == "covered"
    assert len(perceived.scene.candidates) == 1
    found = container_reading(perceived.scene)
    assert found is not None
    assert found.lid is not None
    assert found.lid.knob is not None
    x, y, z = found.lid.knob.center_world_m
    assert np.hypot(x - 1.02, y - 0.03) < 0.003
    assert z == pytest.approx(0.07 + 0.005 + 0.015, abs=0.003)
    assert found.lid.knob.size_m == pytest.approx((0.03, 0.03, 0.03), abs=0.006)
    assert found.lid.plate.size_m[:2] == pytest.approx(found.outer.size_m[:2], abs=0.025)


@pytest.mark.parametrize("shape", ["block", "cylinder"])
def test_a_wide_body_is_no_container_and_still_a_candidate(shape: str) -> None:
    wide = body("wide", shape, (0.155, 0.155, 0.05), (0.92, 0.0))  # type: ignore[arg-type]
    shot = shoot(scene(wide))
    perceived = perceive(shot.frame)
    assert perceived.scene.container is None
    assert cover(perceived.scene) == "unknown"
    overlap, candidate = of_body(perceived, shot, 0)
    assert overlap > 0.9
    assert candidate.solid is not None
    assert max(candidate.solid.size_m) > 0.145


def looking_past(x: float, y: float) -> Array:
    """A camera that has the container half out of the image."""
    return look_at(np.array([x - 0.55, y, 0.42]), np.array([x, y, 0.03]), np.array([0.0, 0.0, 1.0]))


def test_a_cut_container_tells_no_membership() -> None:
    shot = shoot(scene(*CROWD, container=box(covered=False)), looking_past(1.0, -0.33))
    container_px = shot.pixels_of(-2)
    assert container_px[:, :2].any()
    perceived = perceive(shot.frame, Target(noun="object", relation="inside"))
    found = perceived.scene.container
    assert found is None or not found.complete
    told = [answers.membership.label for answers in perceived.answers if answers is not None]
    assert told
    assert set(told) == {"unknown"}


def test_an_empty_table_has_nothing_on_it() -> None:
    out_of_view = body("out of view", at_m=(0.3, 0.9))
    perceived = perceive(shoot(scene(out_of_view)).frame)
    assert perceived.scene.candidates == ()
    assert perceived.scene.container is None
    assert perceived.obstacles.boxes == ()
    assert len(perceived.obstacles.points_world_m) == 0


def screened() -> Scene:
    """A cube behind a corner of two screens."""
    front = Screen(size_m=(0.006, 0.10, 0.12), position_world_m=(0.85, 0.0, 0.0), yaw_rad=0.0)
    side = Screen(size_m=(0.10, 0.006, 0.12), position_world_m=(0.90, -0.053, 0.0), yaw_rad=0.0)
    cube = body("cube", at_m=(0.91, 0.0))
    plain = scene(cube, body("white", "block", (0.04, 0.08, 0.08), (0.85, 0.2)))
    return msgspec.structs.replace(plain, screens=(front, side))


@pytest.mark.parametrize("view", ["center", "right", "close_high"])
def test_screens_are_obstacles_with_room_behind_them(view: str) -> None:
    shot = shoot(screened(), view)
    perceived = perceive(shot.frame)
    screen_px = shot.pixels_of(-4)
    assert all(iou(one.bits, screen_px) < 0.1 for one in perceived.scene.candidates)
    shown = sum(shot.pixels_of(k).sum() >= 100 for k in (0, 1))
    assert len(perceived.scene.candidates) == shown
    assert perceived.obstacles.boxes
    for box3d in perceived.obstacles.boxes:
        assert min(box3d.size_m[:2]) < 0.02
        off = np.subtract(box3d.center_world_m[:2], (0.91, 0.0))
        assert np.hypot(*off) > 0.03


def test_bodies_that_touch_are_two() -> None:
    red = body("red", "cylinder", (0.05, 0.05, 0.06), (0.88, -0.026))
    blue = painted(body("blue", "cylinder", (0.05, 0.05, 0.06), (0.88, 0.026)), (0.1, 0.2, 0.8))
    shot = shoot(scene(red, blue))
    perceived = perceive(shot.frame)
    assert len(perceived.scene.candidates) == 2
    assert of_body(perceived, shot, 0)[0] > 0.85
    assert of_body(perceived, shot, 1)[0] > 0.85


def test_a_body_behind_a_post_is_one() -> None:
    post = Screen(size_m=(0.008, 0.012, 0.16), position_world_m=(0.84, 0.0, 0.0), yaw_rad=0.0)
    wide = body("wide", "block", (0.04, 0.07, 0.06), (0.89, 0.0))
    shot = shoot(msgspec.structs.replace(scene(wide), screens=(post,)))
    assert len(perceive(shot.frame).scene.candidates) == 1
    assert of_body(perceive(shot.frame), shot, 0)[0] > 0.85


def test_the_container_and_a_body_of_its_colour_are_told_apart() -> None:
    brown = box(covered=False).rgb
    bodies = (painted(CROWD[2], brown), painted(CROWD[0], brown))
    shot = shoot(scene(*bodies, container=box(covered=False)))
    perceived = perceive(shot.frame)
    assert len(perceived.scene.candidates) == 2
    assert of_body(perceived, shot, 0)[0] > 0.75
    assert of_body(perceived, shot, 1)[0] > 0.85


@pytest.mark.parametrize(("size", "fov"), [((320, 240), 50.0), ((1280, 720), 45.0)])
@pytest.mark.parametrize("pose_known", [True, False])
def test_other_cameras_do_too(size: tuple[int, int], fov: float, pose_known: bool) -> None:
    shot = shoot(
        scene(*CROWD, container=box(covered=False)),
        "close_high",
        size=size,
        fov_deg=fov,
        pose_known=pose_known,
    )
    perceived = perceive(shot.frame)
    assert len(perceived.scene.candidates) == len(CROWD)
    assert all(of_body(perceived, shot, k)[0] > 0.85 for k in range(len(CROWD)))
    assert cover(perceived.scene) == "open"


def test_a_marking_is_part_of_its_body() -> None:
    marked = [
        msgspec.structs.replace(
            one, marking=Marking(kind="stripe", face="front", rgb=(0.95, 0.95, 0.9), coverage=0.5)
        )
        for one in CROWD[:3]
    ]
    shot = shoot(scene(*marked, container=box(covered=False)))
    perceived = perceive(shot.frame)
    assert len(perceived.scene.candidates) == 3
    assert all(of_body(perceived, shot, k)[0] > 0.85 for k in range(3))
