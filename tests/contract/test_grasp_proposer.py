"""Every grasp proposer keeps the port's promises."""

from collections.abc import Callable

import numpy as np
import pytest
from grasp_clouds import HAND, Upright, cloud, fence, touched_by_hand, uprights, wall
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.grasping.ports import GraspProposer, NoGrasp

PROPOSERS: dict[str, Callable[[], GraspProposer]] = {"antipodal": AntipodalProposer}
CUBE = Upright("cube", (0.05, 0.05, 0.05))
every_proposer = pytest.mark.parametrize("name", sorted(PROPOSERS))


@every_proposer
@settings(deadline=None, max_examples=15)
@given(uprights())
def test_whatever_stands_free_gets_grasps_in_order_of_their_scores(name: str, it: Upright) -> None:
    grasps = PROPOSERS[name]().propose(*cloud(it.points()), HAND)
    scores = [grasp.score for grasp in grasps]
    assert scores == sorted(scores, reverse=True)
    assert all(0.0 < score <= 1.0 for score in scores)
    for grasp in grasps:
        R = grasp.T_world_tcp[:3, :3]
        assert np.allclose(R.T @ R, np.eye(3)) and np.linalg.det(R) > 0.0
        assert grasp.object_width_m < grasp.open_width_m <= HAND.width_max_m


@every_proposer
@settings(deadline=None, max_examples=15)
@given(uprights())
def test_the_pads_close_on_the_object_and_the_tips_stay_above_the_table(
    name: str, it: Upright
) -> None:
    points = it.points()
    grasps = PROPOSERS[name]().propose(*cloud(points), HAND)
    for grasp in grasps:
        T = grasp.T_world_tcp
        assert T[2, 3] - abs(T[2, 0]) * HAND.finger_breadth_m / 2.0 >= 0.005
        local = (points - T[:3, 3]) @ T[:3, :3]
        between = (np.abs(local[:, 0]) < HAND.finger_breadth_m / 2.0) & (local[:, 2] < 0.0)
        assert between.any(), "nothing between the pads"
        across = local[between, 1]
        assert np.ptp(across) < grasp.open_width_m - 0.004, "the fingers would come down on it"
        if grasp is grasps[0]:
            assert np.ptp(across) == pytest.approx(grasp.object_width_m, abs=0.004)
            assert abs(across.max() + across.min()) / 2.0 < 0.003, "off the middle"


@every_proposer
@settings(deadline=None, max_examples=15)
@given(uprights(), uprights(), st.floats(0.0, 2.0 * np.pi), st.floats(0.005, 0.04))
def test_the_hand_comes_in_and_closes_without_touching_anything_else(
    name: str, it: Upright, other: Upright, angle_rad: float, gap_m: float
) -> None:
    far = gap_m + np.hypot(*it.size_m[:2]) / 2.0 + np.hypot(*other.size_m[:2]) / 2.0
    x, y = it.at_m[0] + far * np.cos(angle_rad), it.at_m[1] + far * np.sin(angle_rad)
    neighbour = Upright(other.shape, other.size_m, (x, y), other.yaw_rad).points()
    own = it.points()
    try:
        grasps = PROPOSERS[name]().propose(*cloud(own, neighbour), HAND)
    except NoGrasp as refusal:
        assert refusal.refusal == "access"
        return
    for grasp in grasps[:6]:
        for back_m in np.linspace(0.0, 0.12, 9):
            assert not touched_by_hand(grasp, neighbour, grasp.open_width_m, back_m)
            assert not touched_by_hand(grasp, own, grasp.open_width_m, back_m)
        for width_m in np.linspace(grasp.object_width_m, grasp.open_width_m, 4):
            assert not touched_by_hand(grasp, neighbour, width_m, 0.0)


@every_proposer
def test_the_same_points_get_the_same_grasps_and_stay_as_they_were(name: str) -> None:
    points, mask = cloud(CUBE.points(), wall((0.96, 0.0), (0.005, 0.2, 0.08)))
    before = points.copy()
    first, again = (PROPOSERS[name]().propose(points, mask, HAND) for _ in range(2))
    assert np.array_equal(points, before)
    assert [a.score for a in first] == [b.score for b in again]
    assert all(
        np.array_equal(a.T_world_tcp, b.T_world_tcp) for a, b in zip(first, again, strict=True)
    )


@every_proposer
def test_what_is_wider_than_the_hand_opens_is_refused_for_its_aperture(name: str) -> None:
    wide = Upright("cylinder", (0.15, 0.15, 0.05))
    with pytest.raises(NoGrasp, match="mm wide and the hand takes 140 mm") as caught:
        PROPOSERS[name]().propose(*cloud(wide.points()), HAND)
    assert caught.value.refusal == "aperture"
    assert caught.value.tried["aperture"] > 0


@every_proposer
def test_what_has_walls_close_on_every_side_is_refused_for_its_access(name: str) -> None:
    walls = fence(0.010, 0.10, (0.025, 0.025))
    with pytest.raises(NoGrasp) as caught:
        PROPOSERS[name]().propose(*cloud(CUBE.points(), walls), HAND)
    assert caught.value.refusal == "access"
    assert caught.value.tried["access"] > 0


@every_proposer
def test_a_handful_of_points_is_too_little_of_an_estimate(name: str) -> None:
    with pytest.raises(NoGrasp) as caught:
        PROPOSERS[name]().propose(*cloud(CUBE.points()[:10]), HAND)
    assert caught.value.refusal == "estimate"
