"""Taking the lid off its container, and looking at what was under it."""

from surefetch.common.cell import InformRow
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.skills.execution import Failed
from surefetch.executor.skills.lid_removal import knob_of
from surefetch.executor.skills.place import set_down
from surefetch.executor.skills.take import take
from surefetch.executor.skills.task import Task


def remove_cover(task: Task, row: InformRow) -> str:
    """Take the lid off by its knob, set it down at its place, then look from the row's view.

    Checks: those of `take` and `set_down`. After a failure it looks from the view too, if it can.

    Raises:
        Infeasible: there is no lid, no knob, or no way; nothing was moved.
        Failed: the lid was not taken, or was lost on the way.
    """
    plan = task.plans.lid(task.now(), task.rng)
    if isinstance(plan, Infeasible):
        raise plan
    task.checked(*plan.steps)
    try:
        take(task, plan.pick)
        set_down(task, plan.put_down)
    except Failed as why:
        _look_anyway(task, row, why)
        raise
    task.run.memory = task.run.memory.put(knob_of(plan))
    task.look(row.view, lid=False)
    return "the lid is off and set down"


def _look_anyway(task: Task, row: InformRow, why: Failed) -> None:
    try:
        task.look(row.view)
    except Infeasible as stuck:
        raise Failed(f"{why}; and the view cannot be reached: {stuck}") from why
