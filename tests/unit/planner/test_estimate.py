"""What is kept of container and obstacles, and what the executor is told."""

import numpy as np
from msgspec.structs import replace
from scripted_table import PLATE

from surefetch.common.messages import (
    Box3d,
    ContainerReading,
    CoverState,
    FrameId,
    Lid,
    Mask,
    Observations,
    Track,
)
from surefetch.planner.estimate import Surroundings, estimate_of

OUTER = Box3d(center_world_m=(1.0, 0.0, 0.04), size_m=(0.25, 0.25, 0.08), yaw_rad=0.3)
SCREEN = Box3d(center_world_m=(0.8, 0.3, 0.1), size_m=(0.01, 0.2, 0.2), yaw_rad=0.0)
LID = Lid(plate=PLATE, knob=None)
CONTAINER = ContainerReading(
    box_px=(0.0, 0.0, 1.0, 1.0),
    score=1.0,
    mask=Mask(height=1, width=1, counts=(1,)),
    outer=OUTER,
    inner_size_m=(0.24, 0.24),
    floor_z_m=0.005,
    rim_z_m=0.08,
    complete=True,
    lid=None,
)


def seen(
    container: ContainerReading | None = None,
    cover: CoverState = "unknown",
    obstacles: tuple[Box3d, ...] = (),
    n_points: int = 0,
) -> Observations:
    return Observations(
        frame=FrameId(boot="b", counter=0),
        backend="scripted",
        detections=(),
        container=container,
        cover=cover,
        obstacles=obstacles,
        obstacle_points_world_m=np.zeros((n_points, 3), np.float32),
        duration_s=0.0,
    )


def track(x_m: float, y_m: float) -> Track:
    center = (x_m, y_m, 0.03)
    return Track(
        id=1,
        center_world_m=center,
        solid=Box3d(center_world_m=center, size_m=(0.06, 0.05, 0.06), yaw_rad=0.7),
        points_world_m=np.zeros((0, 3), np.float32),
        hist=None,
        n_observations=0,
        y0=None,
        last_detection="d",
        last_step=0,
    )


def test_a_container_out_of_view_is_remembered() -> None:
    around = Surroundings().after("center", seen(CONTAINER, "open")).after("right", seen())
    estimate = estimate_of((), around, "open")
    assert estimate.container == CONTAINER
    assert estimate.cover == "open"


def test_no_container_ever_seen_is_told_as_unknown() -> None:
    estimate = estimate_of((), Surroundings().after("center", seen()), "open")
    assert estimate.container is None
    assert estimate.cover == "unknown"


def test_a_reading_cut_by_the_border_does_not_replace_a_whole_one_but_its_lid_counts() -> None:
    cut = replace(CONTAINER, complete=False, inner_size_m=(0.1, 0.1))
    covered = replace(CONTAINER, lid=LID)
    around = Surroundings().after("center", seen(covered, "covered"))
    around = around.after("right", seen(cut, "open"))
    assert around.container == CONTAINER
    again = around.after("center", seen(replace(CONTAINER, score=0.5), "open"))
    assert again.container == replace(CONTAINER, score=0.5)
    first = Surroundings().after("center", seen(cut, "open"))
    assert first.container == cut


def test_an_open_container_has_no_lid_and_a_covered_one_keeps_it() -> None:
    around = Surroundings().after("center", seen(replace(CONTAINER, lid=LID), "covered"))
    opened, closed = estimate_of((), around, "open"), estimate_of((), around, "covered")
    assert opened.container == CONTAINER
    assert closed.container == replace(CONTAINER, lid=LID)


def test_obstacles_out_of_view_are_remembered_by_viewpoint() -> None:
    around = Surroundings().after("center", seen(obstacles=(SCREEN,))).after("right", seen())
    assert estimate_of((), around, "open").obstacles == (SCREEN,)
    again = around.after("center", seen())
    assert estimate_of((), again, "open").obstacles == ()


def test_an_obstacle_that_stands_in_a_known_body_is_that_body() -> None:
    in_track = Box3d(center_world_m=(0.71, 0.01, 0.03), size_m=(0.02, 0.02, 0.05), yaw_rad=0.0)
    in_box = Box3d(center_world_m=(1.1, 0.05, 0.03), size_m=(0.02, 0.02, 0.05), yaw_rad=0.0)
    told = seen(CONTAINER, "open", obstacles=(in_track, in_box, SCREEN))
    around = Surroundings().after("center", told)
    assert estimate_of((track(0.7, 0.0),), around, "open").obstacles == (SCREEN,)


def test_points_are_those_of_the_latest_look() -> None:
    around = Surroundings().after("center", seen(n_points=5)).after("right", seen(n_points=3))
    assert len(estimate_of((), around, "open").obstacle_points_world_m) == 3
