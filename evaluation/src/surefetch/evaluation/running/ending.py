"""The end of an episode that was cut short, with all that was seen of it. Pure."""

from surefetch.common.messages import Acted, ActionRecord, Ended, StepRecord
from surefetch.evaluation.running import summary
from surefetch.evaluation.showing.observed import Observed, Step, steps


def aborted(reason: str, because: str, seen: Observed, told: Ended | None) -> Ended:
    """The end for want of infrastructure; `told` is the planner's own account, if it gave one."""
    return _cut_short("aborted", reason, because, seen, told)


def stopped(because: str, seen: Observed, told: Ended | None) -> Ended:
    """The end by the operator, unless the planner had another end first."""
    if told is not None:
        return told
    return _cut_short("stopped", "operator", because, seen, None)


def _cut_short(
    outcome: summary.CutShort, reason: str, because: str, seen: Observed, told: Ended | None
) -> Ended:
    if told is None:
        looks = tuple(_record(step) for step in steps(seen.events))
        actions = tuple(
            ActionRecord(action=h.action, status=h.status, duration_s=h.duration_s)
            for h in (event.happening for event in seen.events)
            if isinstance(h, Acted)
        )
        return summary.cut_short(outcome, reason, because, looks, actions)
    return summary.cut_short(outcome, reason, because, told.steps, told.actions)


def _record(step: Step) -> StepRecord:
    believed, decided = step.believed, step.decided
    return StepRecord(
        q=step.q,
        observations=() if believed is None else believed.counted,
        belief={} if believed is None else believed.belief,
        gamma=() if believed is None else believed.gamma,
        q_values=() if decided is None else decided.q_values,
    )
