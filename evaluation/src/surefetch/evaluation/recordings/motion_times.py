"""How long planned motions take, the fingers' travel included. Modelled, as outcomes tell it."""

from collections.abc import Iterable

from surefetch.executor.robot import ur10e
from surefetch.executor.skills.execution import GRIPPER_S
from surefetch.executor.skills.lid_removal import LidRemoval
from surefetch.executor.skills.pick import Pick
from surefetch.executor.skills.put_down import RELEASE_M
from surefetch.executor.skills.steps import Step


def steps_s(steps: Iterable[Step]) -> float:
    """Of the arm alone."""
    return sum(float(step.trajectory.times_s[-1]) for step in steps)


def pick_s(pick: Pick, width_m: float) -> float:
    """Of opening the hand from a width, taking something, and lifting it."""
    opened, closed = pick.way.open_width_m, pick.way.object_width_m
    return steps_s(pick.steps) + _fingers_s(opened - width_m) + _fingers_s(opened - closed)


def lid_s(plan: LidRemoval, width_m: float) -> float:
    """Of taking a lid and setting it down, without the look at what was under it."""
    return pick_s(plan.pick, width_m) + steps_s(plan.put_down.steps) + _fingers_s(RELEASE_M)


def _fingers_s(travel_m: float) -> float:
    return abs(travel_m) / ur10e.GRIPPER_SPEED_M_S + GRIPPER_S
