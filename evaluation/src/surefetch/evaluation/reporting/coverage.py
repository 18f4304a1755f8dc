"""Does the conformal set hold the truth as often as it should? Over whole episodes. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

from surefetch.common.conformal import coverage_range, episode_score, quantile
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.running.metrics import wilson

ALPHAS: Final = tuple(Fraction(k, 50) for k in range(1, 26))
"""0.02 to 0.5"""


@dataclass(frozen=True)
class Coverage:
    """How many episodes kept the truth in the set at every step."""

    alpha: Fraction
    held: int
    n: int
    band: tuple[float, float]
    """5 % to 95 % of the true coverage over draws of the calibration episodes."""

    @property
    def share(self) -> float:
        """Empirical coverage."""
        return self.held / self.n

    @property
    def interval(self) -> tuple[float, float]:
        """Of the coverage, given these calibration episodes."""
        return wilson(self.held, self.n)


def observed(
    episodes: Sequence[EpisodeResult], alpha: Fraction, n_calibration: int
) -> Coverage | None:
    """Coverage of the sets as they were; None where no episode took a step."""
    seen = [episode for episode in episodes if episode.steps]
    if not seen:
        return None
    held = sum(all(episode.z_in_gamma) for episode in seen)
    return Coverage(alpha, held, len(seen), coverage_range(n_calibration, alpha))


def at_all_levels(
    episodes: Sequence[EpisodeResult], calibration_scores: Sequence[float]
) -> list[Coverage]:
    """Coverage that other levels would have had along the same looks.

    Args:
        episodes: of one policy, none of them used for calibration.
        calibration_scores: one an episode, of the same belief.
    """
    scores = [worst(episode) for episode in episodes if episode.steps]
    found = []
    for alpha in ALPHAS if scores else ():
        q_hat = quantile(calibration_scores, alpha)
        held = sum(score <= q_hat for score in scores)
        band = coverage_range(len(calibration_scores), alpha)
        found.append(Coverage(alpha, held, len(scores), band))
    return found


def worst(episode: EpisodeResult) -> float:
    """How badly the belief treated the truth at its worst visited step."""
    return episode_score([step.p_true for step in episode.steps])


def set_sizes(episodes: Sequence[EpisodeResult]) -> dict[int, int]:
    """How many hypotheses the set held at the last step, by number."""
    sizes = [len(episode.steps[-1].gamma) for episode in episodes if episode.steps]
    return {size: sizes.count(size) for size in sorted(set(sizes))}
