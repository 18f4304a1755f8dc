"""From a command to its outcome: every command ends in exactly one, the arm at rest."""

import time
from typing import Literal

from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput, DeviceFault
from surefetch.common.messages import (
    Command,
    Deliver,
    Grasp,
    Inform,
    Look,
    Outcome,
    PutBack,
    Refusal,
    Verb,
)
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.skills.cover import remove_cover
from surefetch.executor.skills.execution import Failed, Halted
from surefetch.executor.skills.place import deliver, put_back
from surefetch.executor.skills.take import grasp
from surefetch.executor.skills.task import Task

BACK_M = 0.10
Status = Literal["done", "failed", "refused", "stopped"]


def check_names(cell: Cell, verb: Verb) -> None:
    """Raise BadInput where a verb names a view, an action or a place that the cell lacks."""
    match verb:
        case Inform(name=name):
            cell.inform(name)
        case Look(view=view):
            cell.view(view)
        case Deliver(place=place) if place != cell.delivery.name:
            raise BadInput(
                f'cell "{cell.name}" has no place "{place}".\n  Places: {cell.delivery.name}'
            )


def carry_out(task: Task, command: Command) -> Outcome:
    """Do what the command says, once; what came of it."""
    began = time.perf_counter()
    try:
        why = _do_or_draw_back(task, command.verb)
        return _outcome(task, command, began, "done", why)
    except Infeasible as refusal:
        if not task.run.motions:
            return _outcome(task, command, began, "refused", refusal.why, refusal.refusal)
        return _outcome(task, command, began, "failed", refusal.why, refusal.refusal)
    except Failed as failure:
        return _outcome(task, command, began, "failed", str(failure))
    except Halted:
        return _outcome(task, command, began, "stopped", "a stop was asked for; the arm is at rest")


def _do_or_draw_back(task: Task, verb: Verb) -> str:
    """Carry out a verb; where the arm was held up, bring the hand away from what it met.

    Raises:
        Infeasible, Failed, Halted: as the skills; Failed also after a fault of the arm.
    """
    try:
        return _do(task, verb)
    except DeviceFault as fault:
        try:
            task.back_out(BACK_M)
        except (Infeasible, Failed, DeviceFault) as stuck:
            raise Failed(f"{fault}; {stuck}") from fault
        raise Failed(f"{fault}; the hand was drawn back") from fault


def _do(task: Task, verb: Verb) -> str:
    """Carry out a verb; what was done, in words."""
    cell = task.workcell.cell
    match verb:
        case Inform(name=name):
            row = cell.inform(name)
            if row.kind == "remove_cover":
                return remove_cover(task, row)
            task.look(row.view)
            return f"the camera is at {row.view}"
        case Look(view=view):
            task.look(view)
            return f"the camera is at {view}"
        case Grasp(track=track, relation=relation):
            return grasp(task, track, relation)
        case Deliver():
            return deliver(task, cell.delivery)
        case PutBack():
            return put_back(task)


def _outcome(
    task: Task,
    command: Command,
    began_s: float,
    status: Status,
    why: str,
    refusal: Refusal | None = None,
) -> Outcome:
    run = task.run
    return Outcome(
        cmd_id=command.cmd_id,
        status=status,
        refusal=refusal,
        why=why,
        checks=dict(run.checks),
        gripper_width_m=run.devices.gripper.width_m(),
        holding=run.memory.holding is not None and run.gripped(),
        duration_s=run.duration_s,
        planning_s=max(time.perf_counter() - began_s - run.driving_s, 0.0),
        motions=tuple(run.motions),
    )
