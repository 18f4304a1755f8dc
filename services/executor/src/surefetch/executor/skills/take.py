"""Taking something with the hand, and knowing from widths and force whether it was taken.

What the hardware can see too decides: the fingers stop within 15 mm of the width expected and not
at nothing, the device feels a grip, and after the first 50 mm of the lift, and at its top, the
width is what it was within 3 mm.
"""

from dataclasses import replace

from surefetch.common.errors import DeviceFault
from surefetch.common.hypotheses import NEEDS_OPEN, Relation
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.skills.execution import EMPTY_M, Execution, Failed
from surefetch.executor.skills.pick import Pick
from surefetch.executor.skills.task import Task

EXPECTED_WITHIN_M = 0.015
KEPT_WITHIN_M = 0.003


def grasp(task: Task, track: int, relation: Relation) -> str:
    """Grasp a track, taken to stand in this relation, and lift it; what was done, in words.

    Raises:
        Infeasible: it cannot be grasped; nothing was moved.
        Failed: it was not in the hand in the end; the hand is open, and back above if it could be.
    """
    if task.estimate.cover == "covered" and relation in NEEDS_OPEN:
        raise Infeasible("access", f"track {track} is taken to be {relation}, and the lid is on")
    pick, tried = task.plans.target(task.now(), track, task.rng)
    if pick is None:
        assert tried.refusal is not None, "no plan and no refusal"
        raise tried.refusal
    task.checked(*pick.steps)
    take(task, pick)
    return f"track {track} is in the hand, {1e3 * task.run.devices.gripper.width_m():.0f} mm wide"


def take(task: Task, pick: Pick) -> None:
    """Open, approach, descend, close, lift. From the closing on the memory says what is held.

    Raises:
        Failed: closed on nothing or on something else (check `closed_on_object`), or it slipped
            (`width_kept`), or the arm was held up. It was lowered again, the hand opened and
            drawn back.
    """
    run = task.run
    run.grip("open", pick.way.open_width_m)
    try:
        run.follow(pick.approach)
        run.follow(pick.descend)
        width = run.grip("close", 0.0)
        _check_closed(run, width, pick.way.object_width_m)
        run.memory = replace(run.memory, holding=replace(pick.holding, width_m=width))
        _lift(run, pick, width)
    except (Failed, DeviceFault) as why:
        run.memory = replace(run.memory, holding=None)
        run.grip("open", pick.way.open_width_m)
        _draw_back(task, pick, why)
        raise Failed(str(why)) from why


def _lift(run: Execution, pick: Pick, width_m: float) -> None:
    run.follow(pick.lift)
    try:
        _check_kept(run, width_m)
    except Failed:
        run.follow(pick.lift.backwards("lower"))
        raise
    run.follow(pick.lift_on)
    _check_kept(run, width_m)


def _draw_back(task: Task, pick: Pick, why: Exception) -> None:
    try:
        task.back_out(pick.way.back_m)
    except (Infeasible, Failed) as stuck:
        raise Failed(f"{why}; {stuck}") from why


def _check_closed(run: Execution, width_m: float, expected_m: float) -> None:
    met = width_m > EMPTY_M and abs(width_m - expected_m) <= EXPECTED_WITHIN_M
    run.check(
        "closed_on_object",
        met and run.gripped(),
        f"the fingers stopped at {1e3 * width_m:.0f} mm where {1e3 * expected_m:.0f} mm were "
        f"expected",
    )


def _check_kept(run: Execution, width_m: float) -> None:
    now = run.devices.gripper.width_m()
    run.check(
        "width_kept",
        abs(now - width_m) <= KEPT_WITHIN_M and run.gripped(),
        f"it slipped: the fingers went from {1e3 * width_m:.0f} to {1e3 * now:.0f} mm",
    )
