"""Why a closed-loop episode failed, as far as its journals and the truth can tell. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal

from surefetch.common.hypotheses import ABS, UNOBS, Relation, tracked
from surefetch.common.messages import Acted, BeliefReply, Decided, Ended, Event
from surefetch.evaluation.running.metrics import Verdict

Cause = Literal["perception", "association", "belief", "planning", "execution", "infrastructure"]
MATCHES: Final[dict[Relation, str]] = {"inside": "MI", "outside": "MO"}
"""The observation that a target deserves, by its relation."""


@dataclass(frozen=True)
class Look:
    """One step, with what the scorer knows of it."""

    q: str
    seen: tuple[str, ...]
    """Observations of the target's track and what the track showed: ``"2 MI"``."""
    truth: str
    """The true hypothesis z*."""
    p_truth: float
    gamma: tuple[str, ...]


@dataclass(frozen=True)
class Findings:
    """What happened to the target, and what probably went wrong."""

    cause: Cause | None
    """None: nothing went wrong."""
    why: str
    looks: tuple[Look, ...] = ()
    target_tracks: tuple[int, ...] = ()
    """Tracks that ever took a detection of the target."""
    grasped_body: str | None = None
    """What lay under the grasped track's last detection."""
    refusals: tuple[str, ...] = ()
    """Of grasping the target's tracks."""
    failed_actions: tuple[str, ...] = ()


@dataclass
class _Story:
    """What is gathered over the looks."""

    looks: list[Look] = field(default_factory=list)
    target_tracks: list[int] = field(default_factory=list)
    bodies: dict[int, list[str | None]] = field(default_factory=dict)
    """Bodies under the detections of each track, in order."""
    latest: dict[int, str] = field(default_factory=dict)
    """The newest counted observation of each track."""


def findings(
    verdict: Verdict | None,
    ended: Ended,
    events: Sequence[Event],
    replies: Sequence[BeliefReply],
    under: Mapping[str, str | None],
    *,
    target: str | None,
    relation: Relation | None,
) -> Findings:
    """The target's story, and the part of the system in which it went wrong.

    Args:
        verdict: as the scorer counts the episode.
        ended: the planner's account.
        events: of the episode.
        replies: of the belief service, a look each.
        under: the body under each detection.
        target: the body asked for, None when it is absent.
        relation: the target's.
    """
    qs = [step.q for step in ended.steps]
    story = _story(replies, under, target, relation, qs)
    grasped = None
    if ended.track is not None:
        grasped = next(iter(reversed(story.bodies.get(ended.track, []))), None)
    told = Findings(
        cause=None,
        why="",
        looks=tuple(story.looks),
        target_tracks=tuple(story.target_tracks),
        grasped_body=grasped,
        refusals=_refusals(events, story.target_tracks),
        failed_actions=_failed(events),
    )
    cause, why = _cause(verdict, ended, story, told, target, relation)
    return replace(told, cause=cause, why=why)


def _story(
    replies: Sequence[BeliefReply],
    under: Mapping[str, str | None],
    target: str | None,
    relation: Relation | None,
    qs: Sequence[str],
) -> _Story:
    story = _Story()
    current: int | None = None
    for number, reply in enumerate(replies):
        for assigned in reply.assigned:
            if assigned.track is None:
                continue
            body = under.get(assigned.detection)
            story.bodies.setdefault(assigned.track, []).append(body)
            if assigned.counted and assigned.y is not None:
                story.latest[assigned.track] = assigned.y
            if target is not None and body == target:
                current = assigned.track
                if current not in story.target_tracks:
                    story.target_tracks.append(current)
        truth = _truth(target, relation, current)
        story.looks.append(
            Look(
                q=qs[number] if number < len(qs) else "",
                seen=_seen(reply, under, target),
                truth=truth,
                p_truth=reply.belief.get(truth, 0.0),
                gamma=reply.gamma,
            )
        )
    return story


def _seen(
    reply: BeliefReply, under: Mapping[str, str | None], target: str | None
) -> tuple[str, ...]:
    """What was answered about the target in one look, by track; `dropped` has no track."""
    return tuple(
        f"{'dropped' if a.track is None else a.track} {a.y or 'unanswered'}"
        for a in reply.assigned
        if target is not None and under.get(a.detection) == target
    )


def _truth(target: str | None, relation: Relation | None, track: int | None) -> str:
    if target is None or relation is None:
        return ABS
    return UNOBS if track is None else tracked(track, relation)


def _refusals(events: Sequence[Event], tracks: Sequence[int]) -> tuple[str, ...]:
    return tuple(
        f"step {event.step}: T{verdict.track} {verdict.refusal}: {verdict.why}"
        for event in events
        if isinstance(event.happening, Decided)
        for verdict in event.happening.feasibility.grasps
        if verdict.track in tracks and not verdict.feasible
    )


def _failed(events: Sequence[Event]) -> tuple[str, ...]:
    return tuple(
        f"step {event.step}: {event.happening.action} {event.happening.status}: "
        f"{event.happening.why}"
        for event in events
        if isinstance(event.happening, Acted) and event.happening.status != "done"
    )


def _cause(
    verdict: Verdict | None,
    ended: Ended,
    story: _Story,
    told: Findings,
    target: str | None,
    relation: Relation | None,
) -> tuple[Cause | None, str]:
    if verdict in (None, "success"):
        return None, ""
    if verdict in ("aborted", "stopped"):
        return "infrastructure", ended.because
    if verdict == "wrong_object":
        return _wrong_object(ended, story, told, target)
    if verdict in ("grasp_failed", "interaction_failed"):
        return "execution", (told.failed_actions or (ended.because,))[-1]
    return _not_fetched(story, told, relation)


def _wrong_object(
    ended: Ended, story: _Story, told: Findings, target: str | None
) -> tuple[Cause, str]:
    if ended.track is None or (target is not None and told.grasped_body == target):
        return "execution", "the fingers closed on another body than the one that was aimed at"
    bodies = {body for body in story.bodies.get(ended.track, []) if body is not None}
    if len(bodies) > 1:
        return "association", f"T{ended.track} took detections of {', '.join(sorted(bodies))}"
    answered = story.latest.get(ended.track, "nothing")
    if answered.startswith("M"):
        return "perception", f"T{ended.track} is {told.grasped_body}, and was answered {answered}"
    return "belief", f"T{ended.track} is {told.grasped_body}, was last answered {answered}"


def _not_fetched(story: _Story, told: Findings, relation: Relation | None) -> tuple[Cause, str]:
    """The target is there, and the episode ended without a try to grasp it."""
    if told.failed_actions:
        return "execution", told.failed_actions[-1]
    if not story.target_tracks:
        return "perception", "the target was detected in no look, or had no centre"
    if len(story.target_tracks) > 1:
        named = ", ".join(f"T{track}" for track in story.target_tracks)
        return "association", f"the target's detections are spread over {named}"
    (track,) = story.target_tracks
    answered = story.latest.get(track, "nothing")
    if answered == "mismatch" or (
        relation and answered in MATCHES.values() and answered != MATCHES[relation]
    ):
        return "perception", f"the target was last answered {answered}"
    if told.refusals and story.looks[-1].gamma == (story.looks[-1].truth,):
        return "execution", told.refusals[-1]
    last = story.looks[-1]
    where = f"p(truth) {last.p_truth:.3f} at the end, the target answered {answered}"
    if told.refusals:
        where += f"; {told.refusals[-1]}"
    return "belief", where
