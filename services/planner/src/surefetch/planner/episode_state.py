"""What an episode knows between two turns, as one frozen value, and how it changes. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from surefetch.common.cell import InformRow
from surefetch.common.messages import BeliefReply, Estimate, FrameInfo, Observations
from surefetch.planner.actions import State
from surefetch.planner.estimate import NOTHING_SEEN, Surroundings, estimate_of
from surefetch.planner.looks import condition, cover_after, gives_what_it_promised


@dataclass(frozen=True, eq=False)
class EpisodeState:
    """Everything that decides how an episode goes on, beside the belief."""

    view: str
    """Viewpoint from which the next look is taken."""
    at_view: bool = False
    """False: the arm may stand elsewhere, and moves there first."""
    step: int = 0
    """Looks that were believed."""
    cover: State = "open"
    """As last verified. Where no container was ever seen, nothing is covered."""
    used: frozenset[str] = frozenset()
    """Information actions that gave their fresh observation."""
    failures: Mapping[str, int] = field(default_factory=dict)
    """By information action: tries that gave none."""
    grasp_failures: Mapping[int, int] = field(default_factory=dict)
    """By track."""
    tried: InformRow | None = None
    """Information action that was executed and whose fresh observation is due."""
    counted: frozenset[tuple[str, State]] = frozenset()
    """Views, each with the cover state, whose answers the belief has."""
    seen_from: Mapping[int, str | None] = field(default_factory=dict)
    """By track, the viewpoint of its latest detection."""
    around: Surroundings = field(default_factory=Surroundings)
    estimate: Estimate = NOTHING_SEEN
    n_actions: int = 0
    """Information actions and grasps that were executed."""


@dataclass(frozen=True)
class LookedAt:
    """How the belief is to take one look."""

    q: str
    counted: bool


def look(
    state: EpisodeState, rows: tuple[InformRow, ...], frame: FrameInfo, seen: Observations
) -> tuple[EpisodeState, LookedAt]:
    """The state after a frame was perceived: cover, surroundings, what became of the last action.

    An information action is used up only by the observation for which it was taken.
    """
    cover = cover_after(state.cover, seen.cover)
    q = condition(rows, frame.view, state.tried, cover)
    counts = frame.view is not None and (frame.view, cover) not in state.counted
    after = replace(
        _judged(state, frame.view, cover),
        view=frame.view or state.view,
        at_view=frame.view is not None,
        cover=cover,
        around=state.around.after(frame.view, seen),
    )
    if counts and frame.view is not None:
        after = replace(after, counted=after.counted | {(frame.view, cover)})
    return after, LookedAt(q, counts)


def believe(state: EpisodeState, frame: FrameInfo, reply: BeliefReply) -> EpisodeState:
    """The state after the belief took the look."""
    found = {a.track: frame.view for a in reply.assigned if a.track is not None}
    return replace(
        state,
        step=state.step + 1,
        seen_from={**state.seen_from, **found},
        estimate=estimate_of(reply.tracks, state.around, state.cover),
    )


def informed(state: EpisodeState, row: InformRow, *, done: bool) -> EpisodeState:
    """The state after an information action was executed; what it gave, the next look tells."""
    return replace(
        state,
        view=row.view if done else state.view,
        at_view=done,
        tried=row,
        n_actions=state.n_actions + 1,
    )


def grasped_at(state: EpisodeState, track: int, *, held: bool) -> EpisodeState:
    """The state after a grasp was executed and verified, or was not."""
    failed = state.grasp_failures.get(track, 0) + (not held)
    return replace(
        state,
        at_view=False,
        grasp_failures={**state.grasp_failures, track: failed},
        n_actions=state.n_actions + 1,
    )


def given_up(state: EpisodeState, tries: int) -> frozenset[str]:
    """Information actions that failed for good, as often as they may be tried."""
    return frozenset(name for name, n in state.failures.items() if n >= tries)


def _judged(state: EpisodeState, view: str | None, cover: State) -> EpisodeState:
    """The last information action as used up or failed."""
    row = state.tried
    if row is None:
        return state
    if gives_what_it_promised(row, view, cover):
        return replace(state, tried=None, used=state.used | {row.name})
    failures = {**state.failures, row.name: state.failures.get(row.name, 0) + 1}
    return replace(state, tried=None, failures=failures)
