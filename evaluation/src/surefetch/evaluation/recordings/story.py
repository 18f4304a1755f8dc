"""A walked scene in short: what the belief heard, what was true, and what can be counted. Pure.

Tracks and observations do not depend on fitted numbers, so a story can be believed again with
other numbers in a moment, without its recording.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from surefetch.belief import filter as belief_filter
from surefetch.belief.episode import rules_of
from surefetch.belief.evidence import Seen
from surefetch.belief.filter import FLOOR, Memory
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.parameters import Parameters
from surefetch.evaluation.fitting import fit, fit_evidence
from surefetch.evaluation.fitting.fit_evidence import AnswerCounts
from surefetch.evaluation.recordings.recording import Recording, RecordingTruth
from surefetch.evaluation.recordings.walk import Look


@dataclass(frozen=True, eq=False)
class Heard:
    """One capture as the filter hears it, and the true hypothesis after it."""

    q: str
    tracks: tuple[int, ...]
    seen: tuple[Seen, ...]
    truth: str


@dataclass(frozen=True, eq=False)
class Story:
    """One development scene along its exhaustive path."""

    family: str
    seed: int
    asked: AskedRelation
    heard: tuple[Heard, ...]
    counts: fit.Counts
    answers: AnswerCounts


def tell(
    recording: Recording, truth: RecordingTruth, looks: Sequence[Look], counts: fit.Counts
) -> Story:
    """The story of a scene.

    Args:
        recording: the scene.
        truth: the scorer's file of it.
        looks: along the exhaustive path.
        counts: what all walks of the scene contribute to the categories and the priors.
    """
    return Story(
        recording.family,
        recording.seed,
        recording.target.relation,
        tuple(_heard(look) for look in looks),
        counts,
        fit_evidence.count(looks, truth, recording.target.relation),
    )


def _heard(look: Look) -> Heard:
    return Heard(
        look.q,
        tuple(track.id for track in look.reply.tracks),
        tuple(
            Seen(a.detection, a.track, a.y, look.answers.get(a.detection))
            for a in look.reply.assigned
            if a.track is not None
        ),
        look.truth,
    )


def total(stories: Sequence[Story]) -> fit.Counts:
    """What they contribute together to the categories and the priors."""
    return sum((story.counts for story in stories), fit.Counts())


def log_score(story: Story, parameters: Parameters) -> float:
    """Log b(z*) after the last look, believed with these numbers."""
    model, memory = rules_of(parameters, story.asked).model, Memory()
    for heard in story.heard:
        done = belief_filter.step(memory, heard.tracks, heard.seen, heard.q, model)
        memory = done.memory
    return math.log(max(done.belief.named()[story.heard[-1].truth], FLOOR))
