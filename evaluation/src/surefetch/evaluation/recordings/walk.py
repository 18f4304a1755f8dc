"""A recorded scene, walked along a sequence of information actions with the robot's own belief."""

from collections.abc import Callable, Sequence
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

Believe = Callable[[Update], BeliefReply]
"""One step of the belief service: association, birth, update, conformal set. Keeps the episode."""


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

    @property
    def counted(self) -> dict[int, str]:
        """The observation that counted, by track."""
        return {
            a.track: a.y
            for a in self.reply.assigned
            if a.counted and a.track is not None and a.y is not None
        }


def walk(
    recording: Recording,
    truth: RecordingTruth,
    path: Sequence[str],
    cell: Cell,
    believe: Believe,
    *,
    profile: str,
    remembers: bool = True,
) -> list[Look]:
    """The first look and one after each action of the path, believed afresh from step 0.

    Where the belief does not remember, a track is gone with the look that showed it.
    """
    looks: list[Look] = []
    known: frozenset[int] = frozenset()
    target: int | None = None
    under: dict[int, str | None] = {}
    for step in range(len(path) + 1):
        taken = tuple(path[:step])
        state = state_after(taken, recording.covered, cell)
        update = _update(recording, taken, step, cell, profile)
        reply = believe(update)
        bodies = truth.bodies(state)
        target = _target_track(reply, bodies, truth.target, target if remembers else None)
        under |= {a.track: bodies.get(a.detection) for a in reply.assigned if a.track is not None}
        new = tuple(t.id for t in reply.tracks if t.id not in known)
        known = frozenset(t.id for t in reply.tracks)
        told = {d.id: d.answers for d in update.detections if d.answers is not None}
        z = _hypothesis(truth, target)
        looks.append(Look(update.q, reply, new, target, z, dict(under), told))
    return looks


def _update(
    recording: Recording, taken: tuple[str, ...], step: int, cell: Cell, profile: str
) -> Update:
    state = state_after(taken, recording.covered, cell)
    seen = recording.shot(state)
    return Update(
        episode=f"{recording.family}:{recording.seed} {' '.join(taken)}"[:128],
        step=step,
        obs_seq=step,
        profile=profile,
        backend=recording.backend,
        q=condition_after(taken, cell),
        asked=recording.target.relation,
        counted=True,
        detections=tuple(d for d in seen.detections if d.representative),
        covered=state.cover == "closed",
    )


def _target_track(
    reply: BeliefReply,
    bodies: dict[str, str | None],
    target: str | None,
    previous: int | None,
) -> int | None:
    if target is None:
        return None
    for assigned in reply.assigned:
        if assigned.track is not None and bodies.get(assigned.detection) == target:
            return assigned.track
    return previous


def _hypothesis(truth: RecordingTruth, target_track: int | None) -> str:
    if truth.target is None or truth.relation is None:
        return ABS
    return UNOBS if target_track is None else tracked(target_track, truth.relation)
