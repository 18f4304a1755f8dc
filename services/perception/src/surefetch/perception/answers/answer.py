"""Three scores to one answer. Pure."""

from typing import Final

import numpy as np

from surefetch.common.hypotheses import IDENTITY_LABELS, MEMBERSHIP_LABELS
from surefetch.common.messages import Answer
from surefetch.common.observations import first_of_largest

SURE: Final = 9.0
"""Scores are cut off here: more says nothing."""


def identity(supported: float, unobservable: float, evidence: dict[str, float]) -> Answer:
    """An identity answer; contradiction rises as support falls."""
    return _answer(IDENTITY_LABELS, (supported, -supported, unobservable), evidence)


def membership(inside: float, unknown: float, evidence: dict[str, float]) -> Answer:
    """A membership answer; outside rises as inside falls."""
    return _answer(MEMBERSHIP_LABELS, (inside, -inside, unknown), evidence)


def _answer(
    labels: tuple[str, ...], scores: tuple[float, float, float], evidence: dict[str, float]
) -> Answer:
    a, b, c = (float(np.clip(score, -SURE, SURE)) for score in scores)
    return Answer(
        label=first_of_largest(labels, (a, b, c)),
        scores=(a, b, c),
        evidence={key: float(value) for key, value in evidence.items()},
    )
