"""A recorded scene, looked at along a sequence of information actions, as the belief hears it."""

from collections.abc import Mapping
from dataclasses import dataclass

from surefetch.common.cell import Cell
from surefetch.common.hypotheses import ABS, UNOBS, tracked
from surefetch.common.messages import Answers, BeliefReply, Update
from surefetch.evaluation.recordings.recording import (
    Recording,
    RecordingTruth,
    condition_after,
    state_after,
)


@dataclass(frozen=True, eq=False)
class Look:
    """What was believed after one capture of a walk, and what was true."""

    q: str
    reply: BeliefReply
    new_tracks: tuple[int, ...]
    target_track: int | None
    """The track that the target body was last associated with; None while it has none."""
    truth: str
    """The true hypothesis z*."""
    bodies: dict[int, str | None]
    """The body under the latest detection of each track."""
    answers: dict[str, Answers]
    """By detection of this capture; unanswered ones are missing."""
    covered: bool = False
    """Whether the container was covered."""

    @property
    def counted(self) -> dict[int, str]:
        """The observation that counted, by track."""
        return {
            a.track: a.y
            for a in self.reply.assigned
            if a.counted and a.track is not None and a.y is not None
        }


def look_of(
    update: Update,
    reply: BeliefReply,
    bodies: Mapping[str, str | None],
    truth: RecordingTruth,
    before: Look | None,
    *,
    remembers: bool = True,
) -> Look:
    """One look of a walk.

    Args:
        update: what the belief was told.
        reply: what it answered.
        bodies: under each detection of the capture.
        truth: the scorer's file of the scene.
        before: the look before it, if it is not the first.
        remembers: False: a track is gone with the look that showed it.
    """
    known = frozenset() if before is None else frozenset(t.id for t in before.reply.tracks)
    earlier = before.target_track if before is not None and remembers else None
    target = target_track_of(reply, bodies, truth.target, earlier)
    under = {a.track: bodies.get(a.detection) for a in reply.assigned if a.track is not None}
    return Look(
        q=update.q,
        reply=reply,
        new_tracks=tuple(t.id for t in reply.tracks if t.id not in known),
        target_track=target,
        truth=true_hypothesis(truth, target),
        bodies=under if before is None else before.bodies | under,
        answers={d.id: d.answers for d in update.detections if d.answers is not None},
        covered=update.covered,
    )


def update_after(recording: Recording, taken: tuple[str, ...], cell: Cell, profile: str) -> Update:
    """What the belief is told of the capture at the end of a sequence of information actions."""
    state = state_after(taken, recording.covered, cell)
    seen = recording.shot(state)
    return Update(
        episode=f"{recording.family}:{recording.seed} {' '.join(taken)}"[:128],
        step=len(taken),
        obs_seq=len(taken),
        profile=profile,
        backend=recording.backend,
        q=condition_after(taken, cell),
        asked=recording.target.relation,
        counted=True,
        detections=tuple(d for d in seen.detections if d.representative),
        covered=state.cover == "closed",
    )


def target_track_of(
    reply: BeliefReply,
    bodies: Mapping[str, str | None],
    target: str | None,
    previous: int | None,
) -> int | None:
    """The track that the target body was associated with last, this reply included."""
    if target is None:
        return None
    for assigned in reply.assigned:
        if assigned.track is not None and bodies.get(assigned.detection) == target:
            return assigned.track
    return previous


def true_hypothesis(truth: RecordingTruth, target_track: int | None) -> str:
    """z*, when the target body has this track."""
    if truth.target is None or truth.relation is None:
        return ABS
    return UNOBS if target_track is None else tracked(target_track, truth.relation)
