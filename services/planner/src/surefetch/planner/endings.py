"""The ways in which an episode ends, in words. Pure."""

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import Literal

from surefetch.common.cell import Cell
from surefetch.common.errors import NoAnswer, PeerMissing, Refused, SurefetchError
from surefetch.common.hypotheses import ABS
from surefetch.common.messages import Grasp
from surefetch.planner.account import End
from surefetch.planner.situation import Situation


@dataclass(frozen=True)
class Lift:
    """How a lift was verified."""

    reason: Literal["verified", "verified_by_width"]
    told: str


def deferred(now: Situation, because: str) -> End:
    """A decision: the evidence does not justify a grasp."""
    absent = now.believed.gamma == (ABS,)
    return End("deferred", "absent" if absent else "nothing_left", because)


def nothing_admissible(now: Situation, cell: Cell, because: str) -> End:
    """No action is open: because looking failed for good, or by the rules alone."""
    if not now.given_up:
        return End("stalled", "nothing_admissible", because)
    failed = sorted(now.given_up)
    told = f"{', '.join(failed)} failed for good. {because}"
    return End("failed", _failure(failed, cell), told)


def step_limit(n_actions: int, because: str) -> End:
    """Enough was tried."""
    told = f"{n_actions} actions were taken, and no more are allowed. {because}"
    return End("failed", "step_limit", told)


def look_failed(names: Collection[str], cell: Cell, why: str) -> End:
    """An information action failed, and that ends the episode."""
    told = sentence(f"{', '.join(names)} failed", why)
    return End("failed", _failure(names, cell), told)


def view_failed(view: str, why: str) -> End:
    """The camera does not get to where the next look is to be taken."""
    told = sentence(f"The camera could not be moved to the view {view}", why)
    return End("failed", "view_failed", told)


def grasp_failed(grasp: Grasp, tries: int, why: str) -> End:
    """The target was grasped at and not held, for good."""
    times = "once" if tries == 1 else f"{tries} times"
    told = sentence(f"T{grasp.track} {grasp.relation} was grasped at {times} and not held", why)
    return End("failed", "grasp_failed", told, grasp.track, grasp.relation)


def grasped(grasp: Grasp, lift: Lift, after: str, delivered: bool | None) -> End:
    """The target is held, or was put where it was wanted."""
    told = f"{lift.told} {after}"
    return End("grasped", lift.reason, told, grasp.track, grasp.relation, delivered)


def cut_short(error: SurefetchError) -> End:
    """Infrastructure failed; never a defer."""
    told = " ".join(str(error).split())
    match error:
        case PeerMissing(service=service):
            return End("aborted", f"{service}_died", told)
        case NoAnswer(service=service):
            return End("aborted", f"{service}_silent", told)
        case Refused():
            return End("aborted", "refused", told)
        case _:
            return End("aborted", "infrastructure", told)


def stopped(why: str) -> End:
    """The operator ended it."""
    return End("stopped", "operator", sentence("Stopped by the operator", why))


def sentence(told: str, why: str) -> str:
    """What happened and why, if that is known."""
    return (f"{told}: {why}" if why else told).rstrip(".") + "."


def _failure(names: Iterable[str], cell: Cell) -> str:
    """The reason word of information actions that failed."""
    kinds = {cell.inform(name).kind for name in names}
    return "view_failed" if kinds == {"view"} else "removal_failed"
