"""Does an episode go live as it went in replay? Two courses side by side. Pure."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from surefetch.common.messages import (
    Acted,
    Believed,
    Choice,
    Decided,
    Ended,
    Event,
    Feasibility,
)
from surefetch.evaluation.replaying.episode import Played
from surefetch.evaluation.replaying.scoring import told
from surefetch.evaluation.replaying.world import Report

SAME: Final = 1e-9
"""Beliefs that differ by less are the same."""
VERBS: Final = ("look", "deliver", "put_back")
"""Commands that are no decisions."""


@dataclass(frozen=True, eq=False)
class Stop:
    """One look, what was believed after it, and what was chosen."""

    q: str
    observations: frozenset[str]
    """``TRACK CATEGORY``"""
    belief: Mapping[str, float]
    refused: frozenset[str]
    """``T3: path`` and ``right: reach`` of what the robot could not do."""
    action: str | None


@dataclass(frozen=True, eq=False)
class Course:
    """An episode, look by look."""

    stops: tuple[Stop, ...]
    outcome: str
    reason: str
    why: str = ""

    @property
    def actions(self) -> tuple[str, ...]:
        """Everything that was chosen, in order; what failed is marked."""
        return tuple(stop.action for stop in self.stops if stop.action is not None)


@dataclass(frozen=True)
class Comparison:
    """What is the same in two courses of one episode."""

    same_actions: bool
    same_outcome: bool
    n_looks: int
    """Looks that both took, up to the first difference; after each the beliefs are compared."""
    apart: float
    """The largest difference of two beliefs in one hypothesis after the same looks."""
    why: str
    """The first thing that differs, in words; empty when everything agrees."""

    @property
    def same_beliefs(self) -> bool:
        """Whether all that could be compared agrees, and there was something to compare."""
        return self.n_looks > 0 and self.apart <= SAME


def of_replay(played: Played) -> Course:
    """The course of a replayed episode."""
    stops = []
    for moment in played.moments:
        action = None
        if moment.choice is not None:
            action = told(moment.choice, moment.report or Report(done=True))
        feasibility = None if moment.now is None else moment.now.feasibility
        reply = moment.believed
        counted = frozenset(f"{a.track} {a.y}" for a in reply.assigned if a.counted)
        stops.append(Stop(moment.heard.q, counted, reply.belief, _refused(feasibility), action))
    return Course(tuple(stops), played.end.outcome, played.end.reason, played.end.because)


def of_live(events: Iterable[Event], ended: Ended) -> Course:
    """The course of a live episode, from what its planner published."""
    stops: list[Stop] = []
    chosen: Choice | None = None
    for event in events:
        match event.happening:
            case Believed(q=q, belief=belief, counted=counted):
                stops.append(Stop(q, frozenset(counted), belief, frozenset(), None))
                chosen = None
            case Decided(choice=choice, feasibility=feasibility):
                chosen = choice
                stops[-1] = _chosen(stops[-1], choice, feasibility)
            case Acted(action=action, status=status) if action not in VERBS and status != "done":
                stops[-1] = _failed(stops[-1], chosen)
    _mark_unheld(stops, ended)
    return Course(tuple(stops), ended.outcome, ended.reason, ended.because)


def compare(replay: Course, live: Course) -> Comparison:
    """What agrees; the first difference in the order in which one leads to the next."""
    same_actions = replay.actions == live.actions
    same_outcome = (replay.outcome, replay.reason) == (live.outcome, live.reason)
    gaps = list(_gaps(replay, live))
    apart = max(gaps, default=0.0)
    agree = same_actions and same_outcome and apart <= SAME
    why = "" if agree else next(_differences(replay, live), f"only the end: {live.why}")
    return Comparison(same_actions, same_outcome, len(gaps), apart, why)


def _chosen(stop: Stop, choice: Choice | None, feasibility: Feasibility) -> Stop:
    action = None if choice is None else told(choice, Report(done=True))
    return Stop(stop.q, stop.observations, stop.belief, _refused(feasibility), action)


def _failed(stop: Stop, choice: Choice | None) -> Stop:
    action = None if choice is None else told(choice, Report(done=False))
    return Stop(stop.q, stop.observations, stop.belief, stop.refused, action)


def _mark_unheld(stops: list[Stop], ended: Ended) -> None:
    """A lift that only a look refuted was reported as done."""
    for n, stop in enumerate(stops):
        last = n == len(stops) - 1
        held = last and ended.outcome == "grasped"
        if stop.action and stop.action.startswith("grasp") and "(" not in stop.action and not held:
            stops[n] = Stop(
                stop.q, stop.observations, stop.belief, stop.refused, f"{stop.action} (failed)"
            )


def _refused(feasibility: Feasibility | None) -> frozenset[str]:
    if feasibility is None:
        return frozenset()
    grasps = (f"T{v.track}: {v.refusal}" for v in feasibility.grasps if not v.feasible)
    informs = (f"{v.name}: {v.refusal}" for v in feasibility.informs if not v.feasible)
    return frozenset([*grasps, *informs])


def _gaps(replay: Course, live: Course) -> Iterator[float]:
    """How far apart the beliefs are after each look that both took in the same way."""
    for here, there in zip(replay.stops, live.stops, strict=False):
        if here.q != there.q:
            return
        yield _apart(here, there)
        if here.action != there.action:
            return


def _apart(here: Stop, there: Stop) -> float:
    names = set(here.belief) | set(there.belief)
    return max(abs(here.belief.get(z, 0.0) - there.belief.get(z, 0.0)) for z in names)


def _differences(replay: Course, live: Course) -> Iterator[str]:
    for n, (here, there) in enumerate(zip(replay.stops, live.stops, strict=False), start=1):
        at = f"look {n}"
        if here.q != there.q:
            yield f"{at} was {here.q} in replay, {there.q} live"
        if here.observations != there.observations:
            yield f"{at} was read as {_only(here, there)} in replay, {_only(there, here)} live"
        elif _apart(here, there) > SAME:
            yield f"{at} was believed otherwise, by {_apart(here, there):.1e}"
        if here.action == there.action:
            continue
        yield from _why_another(here, there, at)
    if len(replay.stops) != len(live.stops):
        ends = f"{replay.outcome} ({replay.reason}) in replay, {live.outcome} ({live.reason}) live"
        yield f"it ended after {len(replay.stops)} and {len(live.stops)} looks: {ends}. {live.why}"


def _why_another(here: Stop, there: Stop, at: str) -> Iterator[str]:
    names = [(stop.action or "nothing").split(" (")[0] for stop in (here, there)]
    if names[0] == names[1]:
        yield f"after {at}, it came to {here.action} in replay and to {there.action} live"
        return
    only_there, only_here = there.refused - here.refused, here.refused - there.refused
    chose = f"{here.action} in replay, {there.action} live"
    if only_there or only_here:
        yield (
            f"{at}: refused only in replay: {_list(only_here)}; only live: {_list(only_there)}; "
            f"chosen: {chose}"
        )
    yield f"{at}: chosen: {chose}"


def _only(one: Stop, other: Stop) -> str:
    return _list(one.observations - other.observations)


def _list(words: frozenset[str]) -> str:
    return ", ".join(sorted(words)) or "nothing"
