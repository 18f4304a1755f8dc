"""Putting down what is held, gently, and knowing from widths that it was let go."""

from dataclasses import replace

import numpy as np

from surefetch.common.cell import Delivery
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.planner import Tool
from surefetch.executor.robot import ur10e
from surefetch.executor.skills.execution import EMPTY_M, Execution
from surefetch.executor.skills.pick import opening_m
from surefetch.executor.skills.put_down import GAP_M, RELEASE_M, PutDown, plan_put_down, standing_at
from surefetch.executor.skills.situation import Holding, surroundings
from surefetch.executor.skills.steps import Step, raised
from surefetch.executor.skills.take import KEPT_WITHIN_M
from surefetch.executor.skills.task import Task

RELEASED_M = 0.010
YAWS_RAD = tuple(np.radians(np.arange(0.0, 360.0, 45.0)))
BESIDE_M = (0.0, 0.12, -0.12)
"""Along x from the place's middle, where something already stands there"""


def deliver(task: Task, place: Delivery) -> str:
    """Stand what is held at a place, verify that the hand is empty, go home.

    Checks: `still_held`, `released`, `released_empty`.

    Raises:
        Infeasible: nothing is held, or there is no way; nothing was moved.
        Failed: it was lost on the way, or did not come free.
    """
    holding = _held(task)
    x, y, z = place.position_m
    spots = [(x + beside, y, z) for beside in BESIDE_M]
    here = _yaw_of(task, holding)
    poses = [T for spot in spots for T in standing_at(holding, spot, [here + a for a in YAWS_RAD])]
    plan = plan_put_down(task.workcell, task.now(), poses, f"delivered {holding.name}", task.rng)
    set_down(task, plan)
    _verify_empty(task.run)
    _go_home(task)
    return f"{holding.name} stands at {place.name}; the hand is empty"


def put_back(task: Task) -> str:
    """Put what is held back where it was lifted; checks and errors as `deliver`."""
    holding = _held(task)
    back = raised(holding.T_world_flange, GAP_M / 2.0)
    plan = plan_put_down(
        task.workcell, task.now(), [back], f"returned {holding.name}", task.rng, where_it_was=True
    )
    set_down(task, plan)
    _verify_empty(task.run)
    return f"{holding.name} is back where it was; the hand is empty"


def set_down(task: Task, plan: PutDown) -> None:
    """Carry, lower, open, retreat; the memory follows. Checks `still_held` and `released`.

    Raises:
        Failed: it was lost on the way, or did not come free.
    """
    run = task.run
    holding = _held(task)
    run.follow_all(plan.carry)
    _check_still_held(run, holding)
    run.follow(plan.lower)
    closed = run.devices.gripper.width_m()
    opened = run.grip("release", opening_m(task.workcell, closed, RELEASE_M))
    run.memory = run.memory.put(plan.box)
    run.follow(plan.retreat)
    run.check(
        "released",
        opened - closed >= RELEASED_M and not run.gripped(),
        f"the hand did not come free: it opened by {1e3 * (opened - closed):.0f} mm",
    )


def _held(task: Task) -> Holding:
    if task.run.memory.holding is None:
        raise Infeasible("access", "nothing is in the hand")
    return task.run.memory.holding


def _yaw_of(task: Task, holding: Holding) -> float:
    """Yaw of what is held, as it is in the hand now."""
    T = holding.box_at(ur10e.flange(task.now().q_rad), holding.name).T_world_box
    return float(np.arctan2(T[1, 0], T[0, 0]))


def _check_still_held(run: Execution, holding: Holding) -> None:
    now = run.devices.gripper.width_m()
    kept = abs(now - holding.width_m) <= KEPT_WITHIN_M and run.gripped()
    if not kept:
        run.memory = replace(run.memory, holding=None)
    why = f"{holding.name} was lost on the way: {1e3 * now:.0f} mm between the fingers"
    run.check("still_held", kept, why)


def _verify_empty(run: Execution) -> None:
    width = run.grip("close", 0.0)
    run.check(
        "released_empty",
        width <= EMPTY_M,
        f"the hand is not empty: {1e3 * width:.0f} mm between the fingers",
    )


def _go_home(task: Task) -> None:
    now = task.now()
    home = np.radians(task.workcell.cell.home.q_deg)
    around = surroundings(task.workcell, now)
    tool = Tool(now.width_m)
    to_it = task.workcell.motion.to_joints(now.q_rad, home, around, tool, task.rng)
    task.run.follow(Step("home", to_it, tool, around))
