"""A walked scene in short: what the belief heard, what was true, and what can be counted. Pure.

Tracks and observations do not depend on fitted numbers, so a story can be believed again with
other numbers in a moment, without its recording.
"""

import math
import statistics
from collections.abc import Mapping, Sequence
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
    covered: bool = False


@dataclass(frozen=True, eq=False)
class Story:
    """One development scene along the sequence that sees the most of it."""

    family: str
    seed: int
    asked: AskedRelation
    covered: bool
    """Whether the scene begins with a cover on the container."""
    heard: tuple[Heard, ...]
    counts: Mapping[str, fit.Counts]
    """By profile: of the sequences that it allows."""
    answers: AnswerCounts


def tell(
    recording: Recording,
    truth: RecordingTruth,
    looks: Sequence[Look],
    counts: Mapping[str, fit.Counts],
) -> Story:
    """The story of a scene.

    Args:
        recording: the scene.
        truth: the scorer's file of it.
        looks: along the sequence that sees the most.
        counts: by profile, what all walks contribute to categories, priors and births.
    """
    return Story(
        recording.family,
        recording.seed,
        recording.target.relation,
        recording.covered,
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
        look.covered,
    )


def total(stories: Sequence[Story], profile: str) -> fit.Counts:
    """What they contribute together to categories, priors and births of a profile."""
    return sum((story.counts[profile] for story in stories), fit.Counts())


def log_score(story: Story, parameters: Parameters) -> float:
    """Log b(z*), the mean over the looks, believed with these numbers."""
    model, memory, scores = rules_of(parameters, story.asked).model, Memory(), []
    for heard in story.heard:
        done = belief_filter.step(
            memory, heard.tracks, heard.seen, heard.q, model, covered=heard.covered
        )
        memory = done.memory
        scores.append(math.log(max(done.belief.named()[heard.truth], FLOOR)))
    return statistics.fmean(scores)
