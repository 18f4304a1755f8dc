"""What is unseen, and what a look or a removal is predicted to reveal of it."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_observation import COVERED, OPEN, Known, box, look, observation
from scripted_table import CELL

from surefetch.common.geometry import inverse, rigid, rotation_z, transform
from surefetch.common.messages import Box3d
from surefetch.common.viewpoint import camera_pose
from surefetch.evaluation.policies.unseen import Outlook, views_taken
from surefetch.evaluation.policies.voxels import (
    CENTERS_WORLD_M,
    N_VOXELS,
    in_shadow,
    interior,
    voxel_at,
    within,
)
from surefetch.evaluation.recordings.free_space import FILLED, SHAPE, FreeSpace

VIEWS = [row for row in CELL.informs if row.kind == "view"]
REMOVAL = next(row for row in CELL.informs if row.kind == "remove_cover")
seeds = st.integers(0, 2**32 - 1)
boxes = st.builds(
    lambda x, y, a, b, h, yaw: box(x, y, (a, b, h), yaw),
    st.floats(0.8, 1.1), st.floats(-0.25, 0.25), st.floats(0.03, 0.1), st.floats(0.03, 0.1),
    st.floats(0.03, 0.15), st.floats(-3.0, 3.0),
)  # fmt: skip


def speckled(seed: int) -> FreeSpace:
    grid = np.random.default_rng(seed).choice(3, SHAPE, p=[0.5, 0.48, 0.02])
    return FreeSpace.of(grid.astype(np.int8))


@settings(deadline=None, max_examples=15)
@given(seeds)
def test_only_what_is_unseen_can_be_revealed(seed: int) -> None:
    outlook = Outlook(observation(looks=(speckled(seed),)))
    for row in (*VIEWS, REMOVAL):
        assert not (outlook.revealed(row) & ~outlook.unseen).any()


@settings(deadline=None, max_examples=15)
@given(seeds, seeds)
def test_what_is_found_filled_never_reveals_more(seed: int, more: int) -> None:
    before = speckled(seed)
    grid = before.grid()
    grid[np.random.default_rng(more).random(SHAPE) < 0.02] = FILLED
    for row in VIEWS:
        promised = Outlook(observation(looks=(before,), container=None)).revealed(row)
        now = Outlook(observation(looks=(FreeSpace.of(grid),), container=None)).revealed(row)
        assert not (now & ~promised).any()


@pytest.mark.parametrize("seed", range(4))
def test_a_view_reveals_what_was_predicted_of_it(seed: int) -> None:
    """By depth images of the same boxes from both views."""
    draw = np.random.default_rng(seed).uniform
    stand = [
        box(draw(0.8, 1.1), draw(-0.25, 0.25), tuple(draw(0.03, 0.1, 3)), draw(-3.0, 3.0))
        for _ in range(4)
    ]
    first = look("center", stand)
    for row in VIEWS:
        promised = Outlook(observation(looks=(first,), container=None)).revealed(row)
        then = Outlook(observation(looks=(first, look(row.view, stand)), container=None))
        seen = ~then.unseen & Outlook(observation(looks=(first,))).unseen
        assert (promised & seen).sum() >= 0.85 * promised.sum()
        assert (promised & seen).sum() >= 0.85 * seen.sum()


def test_nothing_is_revealed_behind_a_wall() -> None:
    grid = np.zeros(SHAPE, np.int8)
    grid[:, SHAPE[1] // 2] = FILLED
    now = observation(looks=(FreeSpace.of(grid),), container=None)
    x_m, y_m, z_m = CENTERS_WORLD_M.T
    middle = (x_m > 0.75) & (x_m < 1.15) & (np.abs(y_m) < 0.15) & (z_m < 0.1)
    promised = Outlook(now).revealed(VIEWS[0])
    assert not promised[middle & (y_m > 0.02)].any()
    assert promised[middle & (y_m < -0.02)].mean() > 0.9


def test_removing_a_cover_reveals_the_inside_of_the_container_and_no_view_does() -> None:
    now = observation(looks=(FreeSpace.of(np.zeros(SHAPE, np.int8)),), cover="covered",
                      container=COVERED)  # fmt: skip
    outlook = Outlook(now)
    inside = interior(OPEN)
    assert np.array_equal(np.flatnonzero(outlook.revealed(REMOVAL)), np.sort(inside))
    assert not any(outlook.revealed(row)[inside].any() for row in CELL.covered_views)
    opened = Outlook(replace(now, cover="open", estimate=observation().estimate))
    assert any(opened.revealed(row)[inside].any() for row in VIEWS)


def test_walls_that_nobody_saw_hide_what_is_in_the_container() -> None:
    now = observation(looks=(FreeSpace.of(np.zeros(SHAPE, np.int8)),))
    inside = interior(OPEN)
    low = inside[CENTERS_WORLD_M[inside][:, 2] < 0.02]
    walled = Outlook(now).revealed(VIEWS[0])[low].mean()
    flat = msgspec.structs.replace(now.estimate, container=None)
    bare = Outlook(replace(now, estimate=flat)).revealed(VIEWS[0])[low].mean()
    assert walled < 0.7 < 0.95 < bare


@settings(deadline=None, max_examples=30)
@given(boxes, st.floats(0.0, 0.05))
def test_within_a_box_are_all_voxels_whose_centres_are(one: Box3d, margin_m: float) -> None:
    T = inverse(rigid(rotation_z(one.yaw_rad), np.array(one.center_world_m)))
    half_m = np.array(one.size_m) / 2.0 + margin_m
    expected = (np.abs(transform(T, CENTERS_WORLD_M)) <= half_m).all(axis=1)
    assert np.array_equal(within(one, margin_m), np.flatnonzero(expected))


@settings(deadline=None, max_examples=20)
@given(boxes, seeds)
def test_in_the_shadow_of_a_box_the_way_to_the_eye_passes_through_it(one: Box3d, seed: int) -> None:
    """By points along the way, but where it grazes the box."""
    eye_m = camera_pose(CELL, CELL.view("center"))[:3, 3]
    voxels = np.sort(np.random.default_rng(seed).choice(N_VOXELS, 300, replace=False))
    shadow = in_shadow(one, [eye_m], voxels)
    T = inverse(rigid(rotation_z(one.yaw_rad), np.array(one.center_world_m)))
    along = np.linspace(0.0, 1.0, 600)[:, None, None]
    way_m = eye_m + along * (CENTERS_WORLD_M[voxels] - eye_m)
    local_m = np.abs(transform(T, way_m.reshape(-1, 3))).reshape(*way_m.shape)
    for slack_m, is_bound in ((-0.004, np.setdiff1d), (0.004, lambda a, b: np.setdiff1d(b, a))):
        inside = np.all(local_m <= np.array(one.size_m) / 2.0 + slack_m, axis=2)
        crossed = voxels[inside.any(axis=0) & ~inside[-1]]
        itself = within(one, 0.01)
        assert not len(np.setdiff1d(is_bound(crossed, shadow), itself))


def test_a_track_hides_what_lies_behind_it_and_is_near() -> None:
    known = Known("MO", at_m=(0.9, 0.0))
    outlook = Outlook(observation([known], looks=(look("center", [box(0.9, 0.0)]),)))
    hidden = CENTERS_WORLD_M[outlook.behind(outlook.now.believed.tracks[0])]
    assert len(hidden) > 20
    assert (hidden[:, 0] > 0.87).all()
    assert (np.abs(hidden[:, :2] - (0.9, 0.0)) <= 0.2).all()


def test_points_are_in_the_voxel_whose_centre_is_nearest() -> None:
    numbers = np.arange(0, N_VOXELS, 977)
    assert np.array_equal(voxel_at(CENTERS_WORLD_M[numbers] + 0.004), numbers)
    assert voxel_at(np.array([[0.0, 0.0, 0.0]])).tolist() == [N_VOXELS]


@pytest.mark.parametrize(
    ("used", "names"),
    [((), ["center"]), (("remove_cover",), ["center"]), (("right",), ["center", "right"]),
     (("right_covered", "right"), ["center", "right"])],
)  # fmt: skip
def test_views_taken_are_the_first_and_those_of_used_actions(
    used: tuple[str, ...], names: list[str]
) -> None:
    assert [view.name for view in views_taken(observation(used=used))] == names
