"""From answers to one of seven observations. Pure.

Letters, where a scorer answers by letters, are put back into the order of the labels first.
"""

from collections.abc import Sequence
from typing import Final

from surefetch.common.hypotheses import IDENTITY_LABELS, MEMBERSHIP_LABELS
from surefetch.common.messages import Answer, Answers

SUPPORTED, CONTRADICTED, _ = IDENTITY_LABELS
MISMATCH: Final = "mismatch"
_RELATION_LETTER: Final = dict(zip(MEMBERSHIP_LABELS, "IOU", strict=True))


def cyclic_scores(
    letters: Sequence[Sequence[float]], sigma: Sequence[Sequence[int]]
) -> tuple[float, ...]:
    """Mean score of each label over the letter orders in which the question was asked.

    Args:
        letters: ``letters[m][k]``, the logit of answer letter k under order m.
        sigma: ``sigma[m][j]``, the letter at which label j stood under order m.

    Source: paper, eq:cyclic-question-score.
    """
    n_orders = len(letters)
    return tuple(
        sum(letters[m][sigma[m][label]] for m in range(n_orders)) / n_orders
        for label in range(len(sigma[0]))
    )


def first_of_largest(labels: Sequence[str], scores: Sequence[float]) -> str:
    """The label of the highest score; of tied labels the first."""
    best = max(range(len(labels)), key=lambda j: scores[j])
    return labels[best]


def observation(color: str | None, shape: str | None, marking: str | None, membership: str) -> str:
    """The observation that four answers make; an attribute that was not asked is None.

    Source: paper, text below eq:event-alphabet.
    """
    identity = {color, shape, marking} - {None}
    if CONTRADICTED in identity:
        return MISMATCH
    known = "M" if identity <= {SUPPORTED} else "U"
    return known + _RELATION_LETTER[membership]


def observation_of(answers: Answers) -> str:
    """The observation of one detection's answers."""
    return observation(
        _label(answers.color),
        _label(answers.shape),
        _label(answers.marking),
        answers.membership.label,
    )


def _label(answer: Answer | None) -> str | None:
    return None if answer is None else answer.label
