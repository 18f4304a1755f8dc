"""The conformal threshold and the set of hypotheses that it leaves. Pure, in exact arithmetic."""

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction


def episode_score(truth_beliefs: Sequence[float]) -> float:
    """How badly an episode's belief treated the truth at its worst step.

    Source: paper, eq:scene-nonconformity.
    """
    return max(1.0 - b for b in truth_beliefs)


def rank(n: int, alpha: Fraction) -> int:
    """Which of n sorted scores is the threshold: ⌈(n + 1)(1 − α)⌉. Above n: none of them."""
    return math.ceil((n + 1) * (1 - alpha))


def quantile(scores: Sequence[float], alpha: Fraction) -> float:
    """The threshold q̂: the score of that rank; +inf while there are too few episodes.

    Source: paper, text above eq:conformal-set.
    """
    k = rank(len(scores), alpha)
    return sorted(scores)[k - 1] if k <= len(scores) else math.inf


def conformal_set(belief: Mapping[str, float], q_hat: float) -> tuple[str, ...]:
    """Γ: the hypotheses that the belief does not rule out, in the order of the belief.

    Source: paper, eq:conformal-set.
    """
    return tuple(z for z, b in belief.items() if 1.0 - b <= q_hat)


def coverage_range(n: int, alpha: Fraction, *, tail: float = 0.05) -> tuple[float, float]:
    """Between which true coverages n calibration episodes leave us, `tail` beyond each side.

    Over draws of the calibration episodes the true coverage is Beta(k, n + 1 − k) distributed,
    and Beta's distribution function at x is the chance of k or more successes in n trials at x.

    Source: Vovk, Conditional validity of inductive conformal predictors (2012), proposition 2a.
    """
    k = rank(n, alpha)
    if k > n:
        return 1.0, 1.0
    return _beta_quantile(k, n, tail), _beta_quantile(k, n, 1.0 - tail)


def _beta_quantile(k: int, n: int, p: float) -> float:
    """Where the Beta(k, n + 1 − k) distribution function reaches p, by bisection."""
    low, high = 0.0, 1.0
    while high - low > 1e-9:
        middle = (low + high) / 2.0
        if _at_least(k, n, middle) < p:
            low = middle
        else:
            high = middle
    return (low + high) / 2.0


def _at_least(k: int, n: int, x: float) -> float:
    """The chance of k or more successes in n trials of chance x, 0 < x < 1."""
    return math.fsum(
        math.exp(
            math.lgamma(n + 1)
            - math.lgamma(j + 1)
            - math.lgamma(n - j + 1)
            + j * math.log(x)
            + (n - j) * math.log1p(-x)
        )
        for j in range(k, n + 1)
    )
