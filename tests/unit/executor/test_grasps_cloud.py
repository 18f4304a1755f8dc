import numpy as np
import pytest
from grasp_clouds import Upright
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from surefetch.common.geometry import Array, inverse, transform
from surefetch.common.messages import Box3d, Estimate, Shape, Track
from surefetch.executor.grasping.cloud import BEYOND_SOLID_M, NEAR_M, grasp_cloud
from surefetch.executor.motion.obstacles import named

SIZE_M = 0.06


def track(
    i: int, shape: Shape, x: float, y: float = 0.0, yaw: float = 0.0, *, solid: bool = True
) -> Track:
    """A track of which the half towards the robot and the top were seen."""
    it = Upright(shape, (SIZE_M, SIZE_M, SIZE_M), (x, y), yaw)
    points = it.points()
    seen = points[(points[:, 0] < x + 0.1 * SIZE_M) | (points[:, 2] > 0.99 * SIZE_M)]
    box = Box3d(center_world_m=(x, y, SIZE_M / 2.0), size_m=it.size_m, yaw_rad=yaw)
    return Track(
        id=i,
        center_world_m=box.center_world_m,
        solid=box if solid else None,
        points_world_m=seen.astype(np.float32),
        hist=None,
        n_observations=1,
        y0=None,
        last_detection="d",
        last_step=0,
    )


def estimate(*tracks: Track, points: Array | None = None) -> Estimate:
    seen = np.zeros((0, 3)) if points is None else points
    return Estimate(
        tracks=tracks,
        container=None,
        cover="unknown",
        obstacles=(),
        obstacle_points_world_m=seen.astype(np.float32),
    )


def own_points(one: Track, *others: Track) -> Array:
    points, mask = grasp_cloud(estimate(one, *others), one)
    own: Array = points[mask]
    return own


@settings(deadline=None, max_examples=30)
@given(st.sampled_from(["cube", "cylinder", "ball"]), st.floats(-3.0, 3.0))
def test_an_object_is_as_wide_behind_as_it_is_seen_to_be_in_front(shape: Shape, yaw: float) -> None:
    one = track(0, shape, 0.9, 0.1, yaw)
    assert one.solid is not None
    own = own_points(one) - [0.9, 0.1, 0.0]
    gone = cKDTree(own * [-1.0, -1.0, 1.0]).query(own)[0]
    assert gone.max() < 1e-6, "turned by 180 degrees it would be another object"
    local = transform(inverse(named("", one.solid).T_world_box), own + [0.9, 0.1, 0.0])
    assert (np.abs(local) <= SIZE_M / 2.0 + BEYOND_SOLID_M + 1e-6).all()


@pytest.mark.parametrize(("shape", "corners"), [("cube", True), ("cylinder", False)])
def test_corners_are_filled_in_where_corners_were_seen(shape: Shape, corners: bool) -> None:
    own = own_points(track(0, shape, 0.9)) - [0.9, 0.0, 0.0]
    assert (np.abs(own[:, :2]) > 0.45 * SIZE_M).all(axis=1).any() == corners


def test_neighbours_are_around_the_object_and_never_part_of_it() -> None:
    one, other = track(0, "cube", 0.90), track(1, "cube", 0.99)
    points, mask = grasp_cloud(estimate(one, other), one)
    assert (points[mask][:, 0] < 0.94).all()
    assert len(points[~mask]) and (points[~mask][:, 0] > 0.95).all()


def test_what_is_too_far_for_the_hand_is_left_out() -> None:
    one, far = track(0, "cube", 0.90), track(1, "cube", 0.90 + NEAR_M + 0.1)
    _, mask = grasp_cloud(estimate(one, far), one)
    assert mask.all()


def test_points_that_no_box_explains_are_in_the_way() -> None:
    one = track(0, "cube", 0.90)
    points, mask = grasp_cloud(estimate(one, points=np.array([[0.9, 0.08, 0.05]])), one)
    assert np.linalg.norm(points[~mask] - [0.9, 0.08, 0.05], axis=1).max() < 0.02


def test_without_a_solid_only_what_was_seen_is_the_object() -> None:
    one = track(0, "cube", 0.90, solid=False)
    assert len(own_points(one)) == len(one.points_world_m)
