"""From which belief on a policy may grasp, so that few of its grasps are at wrong objects. Pure.

The set Γ says nothing of grasps in absent scenes or of how sure the one eligible hypothesis is;
this bounds what matters, the rate of episodes in which a wrong object is grasped at.

Source: Angelopoulos et al., Learn then test (2021): thresholds are hypotheses "the rate is above
AT_MOST", tested one after the other from the safest down, each by an exact binomial bound; the
first that cannot be rejected ends it. Then the chance that the chosen one's rate is above AT_MOST
is below DELTA, for episodes like those it was tried on. `study commit` tries them on development,
where the belief was fitted as well, so that of new episodes it promises somewhat too much.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from scipy.stats import beta

AT_MOST: Final = 0.02
"""Rate of episodes with a wrong grasp."""
DELTA: Final = 0.1
GRID: Final = (0.95, *(round(0.05 * n, 2) for n in range(18, 5, -1)), 0.0)
"""From the safest down; 0 lets the conformal set alone decide."""


@dataclass(frozen=True)
class Tried:
    """What one threshold led to."""

    at_least: float
    n_episodes: int
    n_wrong: int
    """Episodes in which a wrong object was grasped at."""
    n_successes: int

    @property
    def upper_bound(self) -> float:
        """Above the rate of wrong grasps with confidence 1 - DELTA (Clopper and Pearson)."""
        if self.n_wrong >= self.n_episodes:
            return 1.0
        return float(beta.ppf(1.0 - DELTA, self.n_wrong + 1, self.n_episodes - self.n_wrong))


def lowest_safe(tried: Sequence[Tried]) -> Tried | None:
    """The last threshold, from the highest down, before the first that is not surely safe.

    Args:
        tried: of one policy on the same episodes, in any order.

    Returns:
        None where not even the highest is safe.
    """
    chosen = None
    for one in sorted(tried, key=lambda one: -one.at_least):
        if one.upper_bound >= AT_MOST:
            return chosen
        chosen = one
    return chosen
