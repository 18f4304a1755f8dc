import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from surefetch.common.geometry import Array
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.robot import kinematics, ur10e

JOINTS = arrays(np.float64, 6, elements=st.floats(-1.0, 1.0)).map(lambda q: q * ur10e.Q_MAX_RAD)


@pytest.mark.parametrize(
    ("q", "position_m"),
    [
        ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [1.18425, 0.29070, 0.06085]),
        ([0.0, -np.pi / 2, 0.0, -np.pi / 2, 0.0, 0.0], [0.0, 0.29070, 1.48480]),
        ([0.3, -1.2, 1.5, -1.9, -1.57, 0.4], [0.79994, 0.42984, 0.46986]),
    ],
)
def test_the_flange_is_where_the_nominal_arm_has_it(
    q: list[float], position_m: list[float]
) -> None:
    assert ur10e.flange(np.array(q))[:3, 3] == pytest.approx(position_m, abs=1e-5)


def clear_of_singularities(q: Array) -> bool:
    far = kinematics.singularity(q)
    return min(far.wrist, far.elbow, far.shoulder_m) > 0.01


@given(JOINTS)
def test_every_branch_reaches_the_pose(q: Array) -> None:
    assume(clear_of_singularities(q))
    T = ur10e.flange(q)
    found = kinematics.solve(T)
    miss_m, angle = kinematics.residuals(found, T)
    assert miss_m.max() < kinematics.RESIDUAL_M
    assert angle.max() < kinematics.RESIDUAL_RAD
    assert np.abs(np.sin((found - q) / 2.0)).max(axis=1).min() < 1e-5  # q itself is one of them


@given(st.floats(-1.0, 1.0))
def test_a_pose_at_the_wrist_singularity_is_still_reached(turn: float) -> None:
    T = ur10e.flange(np.array([0.3, -1.2, 1.5, -0.9, 0.0, turn]))
    assert kinematics.residuals(kinematics.solve(T), T)[0].max() < kinematics.RESIDUAL_M


@given(JOINTS, JOINTS)
def test_solutions_keep_the_margin_to_the_limits_and_come_nearest_first(
    q: Array, near: Array
) -> None:
    assume(clear_of_singularities(q))
    T = ur10e.flange(q)
    try:
        found = kinematics.solutions(T, near)
    except Infeasible as error:
        assert error.refusal == "limits"
        return
    assert kinematics.inside_limits(found)
    assert (np.diff(kinematics.effort_s(found, near)) >= 0.0).all()
    assert kinematics.residuals(found, T)[0].max() < kinematics.RESIDUAL_M


def test_a_pose_out_of_reach_is_refused_with_how_far_it_is() -> None:
    T = ur10e.flange(np.zeros(6))
    T[:3, 3] = [2.0, 0.0, 0.5]
    with pytest.raises(Infeasible, match=r"misses by \d+ mm") as caught:
        kinematics.solve(T)
    assert caught.value.refusal == "reach"


def test_whole_turns_are_offered_where_the_limits_allow() -> None:
    q = np.radians([[100.0, -80.0, 90.0, -100.0, -90.0, 20.0]])
    variants = kinematics.with_turns(q)
    assert len(variants) == 2**5  # each joint but the elbow has one more turn
    assert np.allclose(np.cos(variants), np.cos(q))


@pytest.mark.parametrize(
    ("q_deg", "near"),
    [
        ([0.0, -90.0, 90.0, -90.0, 0.0, 0.0], True),
        ([0.0, -90.0, 0.0, -90.0, -90.0, 0.0], True),
        ([0.0, -90.0, 90.0, -90.0, -90.0, 0.0], False),
    ],
)
def test_singular_configurations_are_told(q_deg: list[float], near: bool) -> None:
    assert kinematics.singularity(np.radians(q_deg)).near is near


def test_fingertips_draw_back_as_they_open() -> None:
    drawn = ur10e.retraction_m(np.array([0.0, 0.04, 0.08, 0.12, 0.16]))
    assert drawn == pytest.approx([0.0, 0.0007, 0.0066, 0.0194, 0.0461], abs=1e-4)
    assert ur10e.tcp(0.10)[2, 3] < ur10e.tcp(0.04)[2, 3]


@settings(deadline=None)
@given(JOINTS, arrays(np.float64, 6, elements=st.floats(-0.05, 0.05)))
def test_the_nearest_configuration_is_the_first_of_all(q: Array, off: Array) -> None:
    q = 0.9 * q
    assume(clear_of_singularities(q))
    T, near = ur10e.flange(q), q + off
    first = kinematics.solutions(T, near)[0]
    found = kinematics.nearest(T, near)
    assert kinematics.effort_s(found, near) == pytest.approx(
        kinematics.effort_s(first, near), abs=1e-9
    )
    assert kinematics.residuals(found[None], T)[0][0] < 1e-4
