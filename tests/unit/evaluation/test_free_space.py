"""What a frame tells of the space over the table."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.messages import Frame, FrameId, FrameInfo
from surefetch.evaluation.recordings import free_space
from surefetch.evaluation.recordings.free_space import (
    FILLED,
    FREE,
    SHAPE,
    UNSEEN,
    FreeSpace,
    fused,
    seen_in,
)

grids = st.integers(0, 2**32 - 1).map(
    lambda seed: np.random.default_rng(seed).integers(0, 3, SHAPE).astype(np.int8)
)


@settings(deadline=None, max_examples=20)
@given(grids)
def test_a_grid_survives_being_packed(grid: free_space.Grid) -> None:
    assert np.array_equal(FreeSpace.of(grid).grid(), grid)


@settings(deadline=None, max_examples=20)
@given(st.lists(grids, max_size=3))
def test_together_they_have_seen_what_any_has_seen(each: list[free_space.Grid]) -> None:
    together = fused(each)
    seen = np.zeros(SHAPE, bool)
    for grid in each:
        seen |= grid != UNSEEN
    assert np.array_equal(together != UNSEEN, seen)
    if each:
        last = each[-1] != UNSEEN
        assert np.array_equal(together[last], each[-1][last])


def test_above_a_surface_is_free_at_it_filled_and_below_not_seen() -> None:
    grid = seen_in(frame_from_above(height_m=1.0, surface_m=0.105))
    column = grid[30, 40]
    assert (column[:9] == UNSEEN).all()
    assert column[10] == FILLED
    assert (column[12:] == FREE).all()


def test_what_is_outside_the_image_or_was_not_measured_is_not_seen() -> None:
    assert (seen_in(frame_from_above(height_m=1.0, surface_m=1.0)) == UNSEEN).all()
    near = seen_in(frame_from_above(height_m=0.4, surface_m=0.0, focal_px=800.0))
    assert near[0, 0, 0] == UNSEEN
    assert near[30, 40, 15] == FREE


def frame_from_above(height_m: float, surface_m: float, focal_px: float = 400.0) -> Frame:
    """A camera over the middle of the grid that looks down on a level surface everywhere."""
    depth_m = np.full((480, 640), height_m - surface_m, np.float32)
    T_world_camera = np.diag([1.0, -1.0, -1.0, 1.0])
    T_world_camera[:3, 3] = (0.95, 0.0, height_m)
    info = FrameInfo(
        frame=FrameId(boot="b", counter=1),
        view="center",
        width=640,
        height=480,
        K=np.array([[focal_px, 0.0, 319.5], [0.0, focal_px, 239.5], [0.0, 0.0, 1.0]]),
        T_world_camera=T_world_camera,
        captured_s=0.0,
    )
    rgb = np.zeros((480, 640, 3), np.uint8)
    return Frame(info=info, rgb=rgb, depth_m=depth_m, q_rad=(0.0,) * 6, gripper_width_m=0.1)
