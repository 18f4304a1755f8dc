"""Is the belief right as often as it says? Pure."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.hypotheses import ABS, UNOBS
from surefetch.evaluation.replaying.results import EpisodeResult, StepResult

BINS: Final = 10
FLOOR: Final = 1e-300
"""The filter's own."""


@dataclass(frozen=True)
class Bin:
    """Beliefs of about one strength."""

    n: int
    belief: float
    """Mean mass of the heaviest hypothesis."""
    right: float
    """How often it was the truth."""


@dataclass(frozen=True)
class Reliability:
    """Of the beliefs at some steps."""

    n: int
    bins: tuple[Bin, ...]
    expected_error: float
    """Mean over steps of how far a bin's belief is from its frequency."""
    brier: float
    """Mean squared distance of belief and truth, over all hypotheses."""
    log_score: float
    """Mean log b(z*)."""


def by_condition(episodes: Sequence[EpisodeResult]) -> dict[str, Reliability]:
    """Over all counted steps, and over those of each viewing condition."""
    steps = [step for episode in episodes for step in episode.steps if step.counted]
    if not steps:
        return {}
    conditions = sorted({step.q for step in steps})
    return {"all": of(steps)} | {q: of([s for s in steps if s.q == q]) for q in conditions}


def of(steps: Sequence[StepResult]) -> Reliability:
    """Of some steps; at least one."""
    beliefs = [_masses(step) for step in steps]
    heaviest = [max(belief.items(), key=lambda item: item[1]) for belief in beliefs]
    mass = np.array([p for _, p in heaviest])
    right = np.array([z == step.z_true for (z, _), step in zip(heaviest, steps, strict=True)])
    bins = tuple(
        Bin(len(part), float(mass[part].mean()), float(right[part].mean()))
        for part in np.array_split(np.argsort(mass, kind="stable"), min(BINS, len(steps)))
    )
    return Reliability(
        n=len(steps),
        bins=bins,
        expected_error=sum(b.n * abs(b.belief - b.right) for b in bins) / len(steps),
        brier=math.fsum(map(_brier, beliefs, (s.z_true for s in steps))) / len(steps),
        log_score=math.fsum(math.log(max(s.p_true, FLOOR)) for s in steps) / len(steps),
    )


def _masses(step: StepResult) -> dict[str, float]:
    """The hypotheses that the result keeps, the true one among them."""
    return {**step.belief, UNOBS: step.unobs, ABS: step.abs} | {step.z_true: step.p_true}


def _brier(belief: dict[str, float], truth: str) -> float:
    return math.fsum((p - (z == truth)) ** 2 for z, p in belief.items())
