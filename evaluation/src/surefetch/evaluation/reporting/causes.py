"""Why a replayed episode failed: the part of the system that went wrong first. Pure.

The rule, in this order. Aborted: infrastructure. A removal, view or right grasp that failed:
execution. Wrong object: association, where the grasped track once was the target's; perception,
where its last answer was that it fits and this is not true of the body; planning, where the answer
left it open and a view was left; else emission, for the belief made too much of what was answered.
Not fetched: association, where the target went from one track to another; perception, where it
never had a track though a visited view showed it, or was answered not to fit; planning, where no
visited view showed it, or it was given up with a view left; execution, where nothing but the target
was left in Γ and the robot found no way; else emission.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

from surefetch.common.hypotheses import Relation, parse_tracked
from surefetch.evaluation.recordings.recording import BodyMatch
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.running.causes import MATCHES

Cause = Literal["perception", "association", "emission", "planning", "execution", "infrastructure"]
VISIBLE: Final = 0.1
"""Share of the target that a view shows, from which perception could have found it."""


@dataclass(frozen=True)
class Known:
    """What the scorer knows of the scene, besides the results."""

    relation: Relation | None
    """The target's."""
    shown: Mapping[tuple[str, str], float]
    """Share of the target that is visible, by view and cover state."""
    matches: Mapping[str, BodyMatch]
    """By name of the body."""


def cause(episode: EpisodeResult, known: Known) -> tuple[Cause, str] | None:
    """What went wrong, and why it is thought so; None of a success."""
    match episode.verdict:
        case "success":
            return None
        case "aborted" | "stopped":
            return "infrastructure", episode.why
        case "wrong_object":
            return _wrong(episode, known)
        case "grasp_failed" | "interaction_failed":
            tried = [action for action in episode.actions if "(failed" in action]
            return "execution", tried[-1] if tried else episode.why
        case "step_limit":
            return "planning", "the steps ran out"
        case _:
            return _not_fetched(episode, known)


def _wrong(episode: EpisodeResult, known: Known) -> tuple[Cause, str]:
    grasp = next((g for g in episode.grasps if not g.on_target), None)
    if grasp is None:
        return "execution", "the fingers closed on another body than the one that was aimed at"
    if grasp.track in _target_tracks(episode):
        return "association", f"T{grasp.track} was the target's, and then took another body"
    answered = _last_answer(episode, grasp.track)
    body = known.matches.get(grasp.body or "")
    name = grasp.body or "no body"
    if answered is None or body is None:
        return "perception", f"T{grasp.track} is {name}"
    if answered.startswith("M") and not _fits(answered, body):
        return "perception", f"T{grasp.track} is {name}, and was answered {answered}"
    told = f"T{grasp.track} is {name}, was answered {answered}, had b = {grasp.p:.3f}"
    if answered.startswith("U") and (left := _left(episode)):
        return "planning", f"{told}; {left[0]} not seen"
    return "emission", told


def _not_fetched(episode: EpisodeResult, known: Known) -> tuple[Cause, str]:
    tracks = _target_tracks(episode)
    if not tracks:
        best = max((known.shown.get((s.view, s.cover), 0.0) for s in episode.steps), default=0.0)
        if best < VISIBLE:
            return "planning", f"no visited view showed more than {best:.0%} of the target"
        return "perception", f"a visited view showed {best:.0%} of the target, and it has no track"
    if len(tracks) > 1:
        named = ", ".join(f"T{track}" for track in tracks)
        return "association", f"the target was {named}, one after the other"
    answered = _last_answer(episode, tracks[0])
    if answered == "mismatch" or _other_relation(answered, known.relation):
        return "perception", f"the target was last answered {answered}"
    end = episode.steps[-1]
    if set(end.gamma) == {end.z_true}:
        return "execution", "only the target was left in Γ, and the robot found no way to grasp it"
    if left := _left(episode):
        return "planning", f"given up with b(z*) = {end.p_true:.3f}, and {left[0]} not seen"
    return "emission", f"b(z*) = {end.p_true:.3f} after all views, answered {answered}"


def _target_tracks(episode: EpisodeResult) -> list[int]:
    """Tracks that were the target's, in order of first being so."""
    parsed = [parse_tracked(step.z_true) for step in episode.steps]
    return list(dict.fromkeys(found[0] for found in parsed if found is not None))


def _last_answer(episode: EpisodeResult, track: int) -> str | None:
    answers = [
        seen.split(" ", 1)[1]
        for step in episode.steps
        for seen in step.observations
        if seen.split(" ", 1)[0] == str(track)
    ]
    return answers[-1] if answers else None


def _fits(answered: str, body: BodyMatch) -> bool:
    """Whether a body is what a match says of it."""
    named = (body.color, body.shape, body.marking)
    if any(value is False for value in named):
        return False
    told = {category: relation for relation, category in MATCHES.items()}.get(answered)
    return told is None or body.relation is None or body.relation == told


def _other_relation(answered: str | None, relation: Relation | None) -> bool:
    return relation is not None and answered in MATCHES.values() and answered != MATCHES[relation]


def _left(episode: EpisodeResult) -> list[str]:
    """Views that were never taken with the container as it was at the end."""
    end = episode.steps[-1]
    if end.cover == "closed":
        return ["what is under the cover"]
    seen = {step.view for step in episode.steps if step.cover == end.cover}
    tried = {action.split(" ", 1)[0] for action in episode.actions}
    return [view for view in ("right", "close_high") if view not in seen | tried]
