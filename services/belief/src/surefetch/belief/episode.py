"""One episode's belief as one frozen value, and the step that makes the next one of it. Pure."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import msgspec
import numpy as np

from surefetch.belief import filter as belief_filter
from surefetch.belief.attribute_evidence import AttributeEvidence
from surefetch.belief.evidence import NOTHING, CategoryEvidence, Evidence, Seen
from surefetch.belief.filter import Memory, Model
from surefetch.belief.tracking import Tracked, track
from surefetch.common import codec
from surefetch.common.conformal import conformal_set
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import Assigned, BeliefReply, Track, Update
from surefetch.common.observations import observation_of
from surefetch.common.parameters import Parameters

MAX_REPLY_BYTES: Final = 64 * 1024 * 1024
_NO_DIGEST: Final = "-"


@dataclass(frozen=True, eq=False)
class Rules:
    """The numbers that an episode is believed with."""

    model: Model
    q_hat: float


@dataclass(frozen=True, eq=False)
class EpisodeBelief:
    """Everything that is carried from one look to the next."""

    rules: Rules
    tracks: tuple[Track, ...] = ()
    memory: Memory = field(default_factory=Memory)
    digest: str = _NO_DIGEST


def step(before: EpisodeBelief, update: Update) -> tuple[EpisodeBelief, BeliefReply]:
    """Associate, then first belief or birth, then the observations that count, then Γ.

    An update that does not count still moves tracks, and new tracks are still born.
    """
    tracked = track(update.detections, before.tracks, update.step)
    labels = [None if d.answers is None else observation_of(d.answers) for d in update.detections]
    seen = [
        Seen(detection.id, number, label if update.counted else None, detection.answers)
        for detection, number, label in zip(
            update.detections, tracked.track_of, labels, strict=True
        )
        if number is not None
    ]
    ids = [t.id for t in tracked.tracks]
    done = belief_filter.step(
        before.memory, ids, seen, update.q, before.rules.model,
        covered=update.covered, look_counts=update.counted,
    )  # fmt: skip
    tracks = _with_evidence(tracked.tracks, seen, done)
    belief = done.belief.named()
    reply = BeliefReply(
        episode=update.episode,
        step=update.step,
        tracks=tracks,
        assigned=_assigned(update, tracked, labels, done.counted),
        prior=done.prior.named(),
        belief=belief,
        gamma=conformal_set(belief, before.rules.q_hat),
        q_hat=before.rules.q_hat,
        digest=before.digest,
    )
    reply = msgspec.structs.replace(reply, digest=_digest(reply, done.memory))
    return EpisodeBelief(before.rules, tracks, done.memory, reply.digest), reply


def rules_of(parameters: Parameters, asked: AskedRelation) -> Rules:
    """What the belief needs of a profile's fitted numbers when this relation is asked for."""
    model = Model(
        _evidence(parameters, asked),
        parameters.belief_priors(asked),
        parameters.tempering,
        covered_priors=parameters.belief_priors(asked, covered=True),
        births=lambda q, covered: parameters.birth_counts(q, covered=covered),
    )
    return Rules(model, parameters.q_hat())


def _evidence(parameters: Parameters, asked: AskedRelation) -> Evidence:
    if parameters.attribute_evidence is None:
        return CategoryEvidence(parameters.emission())
    return AttributeEvidence(parameters.attribute_evidence, asked, parameters.company)


def _with_evidence(
    tracks: Sequence[Track], seen: Sequence[Seen], done: belief_filter.Step
) -> tuple[Track, ...]:
    """The tracks with how often they were observed, and as what they were observed last."""
    latest = {s.track: s.y for s, counts in zip(seen, done.counted, strict=True) if counts}
    return tuple(
        msgspec.structs.replace(
            t,
            n_observations=done.memory.n_observations.get(t.id, 0),
            y0=latest.get(t.id, t.y0),
        )
        for t in tracks
    )


def _assigned(
    update: Update, tracked: Tracked, labels: Sequence[str | None], counted: Sequence[bool]
) -> tuple[Assigned, ...]:
    """What became of every detection; `counted` is of the tracked ones alone."""
    counts = iter(counted)
    return tuple(
        Assigned(
            detection=detection.id,
            track=number,
            y=label,
            counted=number is not None and next(counts),
        )
        for detection, number, label in zip(
            update.detections, tracked.track_of, labels, strict=True
        )
    )


def _digest(reply: BeliefReply, memory: Memory) -> str:
    """Of this reply, what is known of its tracks and, through its digest, of all before it."""
    known = [memory.known.get(track.id, NOTHING) for track in reply.tracks]
    learnt = np.array([number for of_track in known for number in of_track])
    return hashlib.sha256(
        codec.encode(reply, max_bytes=MAX_REPLY_BYTES) + learnt.tobytes()
    ).hexdigest()
