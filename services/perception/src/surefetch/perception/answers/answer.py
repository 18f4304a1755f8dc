"""Three scores to one answer. Pure."""

from typing import Final

import numpy as np

from surefetch.common.hypotheses import IDENTITY_LABELS, MEMBERSHIP_LABELS
from surefetch.common.messages import Answer
from surefetch.common.observations import first_of_largest

SURE: Final = 9.0
"""Margins count up to here: more says nothing."""


def identity(margin: float, doubt: float, evidence: dict[str, float]) -> Answer:
    """Supported by a margin that exceeds the doubt, contradicted by its opposite."""
    return _answer(IDENTITY_LABELS, margin, doubt, evidence)


def membership(margin: float, doubt: float, evidence: dict[str, float]) -> Answer:
    """Inside by a margin that exceeds the doubt, outside by its opposite."""
    return _answer(MEMBERSHIP_LABELS, margin, doubt, evidence)


def _answer(
    labels: tuple[str, ...], margin: float, doubt: float, evidence: dict[str, float]
) -> Answer:
    counted = float(np.clip(margin, -SURE, SURE))
    scores = (counted, -counted, float(min(doubt, 2 * SURE)))
    return Answer(
        label=first_of_largest(labels, scores),
        scores=scores,
        evidence={key: float(value) for key, value in evidence.items()},
    )
