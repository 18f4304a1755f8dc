"""Walked calibration scenes to the conformal threshold. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from surefetch.common.conformal import coverage_range, episode_score, quantile
from surefetch.common.errors import BadInput
from surefetch.evaluation.recordings.walk import Look

EPISODES: Final = {"paper": 20, "extended": 200}
"""`paper` uses this many, in the order of the recordings; `extended` at least this many."""


@dataclass(frozen=True)
class Calibration:
    """The threshold, and what it rests on."""

    q_hat: float
    n: int
    alpha: Fraction
    true_coverage: tuple[float, float]
    """Between which the true coverage lies, in 90 % of draws of n calibration episodes."""


def score(looks: Sequence[Look]) -> float:
    """How badly one episode's belief treated the truth at its worst step.

    Source: eq:scene-nonconformity.
    """
    return episode_score([look.reply.belief[look.truth] for look in looks])


def calibrate(scores: Sequence[float], alpha: Fraction) -> Calibration:
    """The threshold from one score per episode."""
    return Calibration(
        quantile(scores, alpha), len(scores), alpha, coverage_range(len(scores), alpha)
    )


def episodes_for(profile: str, available: int) -> int:
    """How many of the available episodes a profile is calibrated on.

    Raises:
        BadInput: there are too few.
    """
    needed = EPISODES[profile]
    if available < needed:
        raise BadInput(
            f'profile "{profile}" is calibrated on {needed} episodes; '
            f"the recordings hold {available}.\n"
            f"  Record more: surefetch study record --split calibration "
            f"--episodes {-(-needed // 5)} --out DIR"
        )
    return needed if profile == "paper" else available
