import numpy as np
import pytest
from grasp_clouds import HAND, Upright, cloud, fence, uprights, wall
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.geometry import Array, rotation_z
from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.grasping.footprint import footprint_of
from surefetch.executor.grasping.ports import GraspPose, NoGrasp
from surefetch.executor.robot import ur10e

CUBE = Upright("cube", (0.05, 0.05, 0.05))


def propose(own: Array, *others: Array) -> tuple[GraspPose, ...]:
    return AntipodalProposer().propose(*cloud(own, *others), HAND)


@settings(deadline=None, max_examples=30)
@given(uprights(shapes=("cube", "block")))
def test_boxes_are_taken_square_across_their_narrower_side(it: Upright) -> None:
    best = propose(it.points())[0]
    axis = rotation_z(it.yaw_rad).T @ best.T_world_tcp[:3, 1]
    assert best.object_width_m == pytest.approx(min(it.size_m[:2]), abs=0.003)
    assert np.abs(axis).max() > np.cos(np.radians(3.0))


@settings(deadline=None, max_examples=30)
@given(uprights())
def test_with_room_all_around_the_hand_comes_straight_down_on_the_middle(it: Upright) -> None:
    best = propose(it.points())[0]
    assert np.allclose(best.T_world_tcp[:3, 2], [0.0, 0.0, -1.0])
    assert np.linalg.norm(best.T_world_tcp[:2, 3] - it.at_m) < 0.003
    assert best.T_world_tcp[2, 3] <= max(0.5 * it.size_m[2], 0.0065), "above the equator"


@settings(deadline=None, max_examples=15)
@given(uprights(), st.integers(0, 71), st.floats(-0.1, 0.1), st.floats(-0.1, 0.1))
def test_turning_and_shifting_the_table_turns_and_shifts_the_grasps(
    it: Upright, fives: int, x: float, y: float
) -> None:
    R, t = rotation_z(np.radians(5.0 * fives)), np.array([x, y, 0.0])
    beside = wall((it.at_m[0] + 0.08, it.at_m[1]), (0.01, 0.1, 0.06))
    own = it.points()
    try:
        before = propose(own, beside)
    except NoGrasp:
        before = ()
    try:
        after = propose(own @ R.T + t, beside @ R.T + t)
    except NoGrasp:
        after = ()
    assert len(before) == len(after)
    if before:
        # Three rectangles around a regular hexagon are equally tight: rounding says which one the
        # angles of the proposals are counted from, and something beside it tells them apart.
        within = 0.1 if it.shape == "hexagonal prism" else 0.05
        assert after[0].score == pytest.approx(before[0].score, rel=within)


@settings(deadline=None, max_examples=15)
@given(uprights(), st.floats(0.03, 0.09), st.floats(0.0, 6.28))
def test_more_around_the_object_never_makes_the_best_grasp_better(
    it: Upright, far_m: float, angle_rad: float
) -> None:
    x, y = it.at_m[0] + far_m * np.cos(angle_rad), it.at_m[1] + far_m * np.sin(angle_rad)
    own, post = it.points(), wall((x, y), (0.01, 0.01, 0.08))
    free = propose(own)[0]
    try:
        assert propose(own, post)[0].score <= free.score + 1e-9
    except NoGrasp as refusal:
        assert refusal.refusal == "access"


def test_beside_a_wall_the_fingers_go_along_it() -> None:
    best = propose(CUBE.points(), wall((0.94, 0.0), (0.005, 0.3, 0.10)))[0]
    assert abs(best.T_world_tcp[1, 1]) > np.cos(np.radians(10.0))


def test_the_hands_body_stays_above_a_rim_that_the_fingers_pass() -> None:
    rim_m = 0.118
    best = propose(CUBE.points(), fence(0.035, rim_m, (0.025, 0.025)))[0]
    palm = best.T_world_flange[2, 3] - HAND.palms[0].face_z_m
    assert best.T_world_tcp[2, 2] == pytest.approx(-1.0)
    assert palm > rim_m + 0.005


def test_leans_away_from_a_wall_that_is_too_high_for_the_hands_body() -> None:
    low = Upright("block", (0.03, 0.08, 0.03))
    best = propose(low.points(), wall((0.933, 0.0), (0.02, 0.3, 0.17)))[0]
    approach = best.T_world_tcp[:3, 2]
    assert approach[0] > 0.2, "from the side without the wall"
    assert abs(best.T_world_tcp[1, 1]) > np.cos(np.radians(10.0))


def test_a_hand_that_needs_more_room_opens_wider() -> None:
    free = propose(CUBE.points())[0]
    beside = propose(CUBE.points(), fence(0.028, 0.04, (0.025, 0.025)))[0]
    assert free.open_width_m > beside.open_width_m > beside.object_width_m


@given(st.floats(0.0, 0.15))
def test_the_hand_and_the_arm_agree_on_where_the_fingertips_are(width_m: float) -> None:
    assert float(HAND.tip_z_m(width_m)) == pytest.approx(ur10e.tcp(width_m)[2, 3])


def test_the_flange_stays_while_the_hand_closes() -> None:
    grasp = propose(CUBE.points())[0]
    closed = grasp.T_world_flange @ ur10e.tcp(grasp.object_width_m)
    opened = grasp.T_world_flange @ ur10e.tcp(grasp.open_width_m)
    assert np.allclose(closed, grasp.T_world_tcp)
    assert np.allclose(opened, grasp.T_world_tcp_open)
    assert opened[2, 3] > closed[2, 3], "the tips come down as the hand closes"


@settings(deadline=None)
@given(st.floats(0.01, 0.1), st.floats(0.01, 0.1), st.floats(-3.0, 3.0))
def test_a_footprint_is_as_wide_as_its_points(x: float, y: float, yaw_rad: float) -> None:
    side = np.linspace(-0.5, 0.5, 41)
    square = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2) * [x, y]
    points = square @ rotation_z(yaw_rad)[:2, :2].T + [0.9, 0.1]
    found = footprint_of(points)
    assert np.allclose(found.center_m, [0.9, 0.1], atol=1e-3)
    half = found.half_width_m(np.array([yaw_rad, yaw_rad + np.pi / 2.0]))
    assert half == pytest.approx([x / 2.0, y / 2.0], rel=0.05, abs=1e-3)
    low, high = found.sides_m(np.array([yaw_rad]), np.zeros((1, 1)))
    assert high[0, 0] - low[0, 0] == pytest.approx(y, rel=0.05, abs=2e-3)


def test_a_few_stray_points_do_not_widen_a_footprint() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(-0.02, 0.02, (2000, 2))
    stray = np.concatenate([points, [[0.08, 0.0], [0.0, -0.09], [-0.07, 0.07]]])
    assert np.allclose(footprint_of(points).reach_m, footprint_of(stray).reach_m, atol=1e-3)


def test_what_is_not_symmetric_is_taken_in_the_middle_of_what_the_pads_touch() -> None:
    wedge = Upright("block", (0.06, 0.05, 0.05)).points()
    wedge = wedge[wedge[:, 1] < 0.5 * (wedge[:, 0] - 0.9) + 0.005]
    for grasp in propose(wedge)[:6]:
        T = grasp.T_world_tcp
        local = (wedge - T[:3, 3]) @ T[:3, :3]
        across = local[np.abs(local[:, 0]) < HAND.finger_breadth_m / 2.0, 1]
        assert abs(across.max() + across.min()) / 2.0 < 0.004
        assert np.ptp(across) == pytest.approx(grasp.object_width_m, abs=0.006)
