"""Episodes of two policies on the same scenes, and what can be said of their difference. Pure.

The scene is the unit; families are fixed strata. Everything that is drawn comes from the generator
that is passed in. Source: EVALUATION, paired comparison and families as clusters.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.errors import BadInput
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.running.metrics import mcnemar

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Pairs:
    """Two policies, scene by scene; all arrays (n,)."""

    families: NDArray[np.str_]
    first: Bools
    """Successes."""
    second: Bools
    first_wrong: Bools
    """Another object was grasped, or tried."""
    second_wrong: Bools
    first_cost: Floats
    """Realised."""
    second_cost: Floats

    @property
    def n(self) -> int:
        """Scenes."""
        return len(self.families)

    @property
    def only_first(self) -> int:
        """Scenes in which only the first succeeded."""
        return int(np.sum(self.first & ~self.second))

    @property
    def only_second(self) -> int:
        """Scenes in which only the second succeeded."""
        return int(np.sum(self.second & ~self.first))

    @property
    def psi(self) -> float:
        """Share of scenes on which they differ."""
        return (self.only_first + self.only_second) / self.n

    @property
    def p_mcnemar(self) -> float:
        """Exact, two-sided."""
        return mcnemar(self.only_first, self.only_second)

    @property
    def gains(self) -> Floats:
        """Success of the first less that of the second: 1, 0 or −1."""
        return self.first.astype(np.float64) - self.second

    @property
    def extra_wrong(self) -> Floats:
        """Wrong objects of the first less those of the second."""
        return self.first_wrong.astype(np.float64) - self.second_wrong

    @property
    def extra_cost(self) -> Floats:
        """Realised cost of the first less that of the second."""
        return self.first_cost - self.second_cost


def paired(first: Sequence[EpisodeResult], second: Sequence[EpisodeResult]) -> Pairs:
    """Two policies' episodes, put together by scene.

    Raises:
        BadInput: they did not play the same scenes once each, or there are none.
    """
    ours, theirs = ({(e.family, e.seed): e for e in of} for of in (first, second))
    if not ours or ours.keys() != theirs.keys() or len(ours) != len(first):
        names = ", ".join(of[0].policy if of else "nobody" for of in (first, second))
        raise BadInput(
            f"these policies did not play the same scenes: {names}.\n"
            "  Evaluate them together: surefetch study evaluate --policies A,B --out DIR"
        )
    both = [(episode, theirs[scene]) for scene, episode in ours.items()]
    columns = list(zip(*both, strict=True))

    def bools(column: int, verdict: str) -> Bools:
        return np.array([e.verdict == verdict for e in columns[column]])

    return Pairs(
        families=np.array([family for family, _ in ours]),
        first=bools(0, "success"),
        second=bools(1, "success"),
        first_wrong=bools(0, "wrong_object"),
        second_wrong=bools(1, "wrong_object"),
        first_cost=np.array([e.realized_cost for e in columns[0]]),
        second_cost=np.array([e.realized_cost for e in columns[1]]),
    )


def resampled_means(
    values: Floats, families: NDArray[np.str_], draws: int, rng: np.random.Generator
) -> Floats:
    """Means over scenes drawn with replacement within each family. Uses up rng.

    Args:
        values: (n,), one a scene.
        families: (n,)
        draws: how many.
        rng: the source of the draws.

    Returns:
        (draws,)
    """
    total = np.zeros(draws)
    for family in np.unique(families):
        of = values[families == family]
        total += of[rng.integers(len(of), size=(draws, len(of)))].sum(axis=1)
    return total / len(values)


def interval(means: Floats) -> tuple[float, float]:
    """The middle 95 % of resampled means."""
    low, high = np.quantile(means, [0.025, 0.975])
    return float(low), float(high)


def one_sided(means: Floats) -> tuple[float, float]:
    """The bounds, each of which 95 % of the resampled means do not pass."""
    low, high = np.quantile(means, [0.05, 0.95])
    return float(low), float(high)


def p_worse(means: Floats, margin: float) -> float:
    """Of non-inferiority: how often a resampled difference is at or below −margin."""
    return (1.0 + float(np.sum(means <= -margin))) / (1.0 + len(means))


def p_sign_flip(differences: Floats, draws: int, rng: np.random.Generator) -> float:
    """Two-sided p of no difference in the mean, each scene's sign being as good as its opposite.

    Drawn, with the observed signs counted among the draws. Uses up rng.

    Source: Good, Permutation, Parametric and Bootstrap Tests of Hypotheses (2005), paired samples.
    """
    moved = differences[differences != 0.0]
    if len(moved) == 0:
        return 1.0
    observed = abs(float(moved.sum()))
    signs = rng.integers(2, size=(draws, len(moved)), dtype=np.int8) * 2 - 1
    flipped = np.abs(signs.astype(np.float64) @ moved)
    return (1.0 + float(np.sum(flipped >= observed - 1e-9))) / (1.0 + draws)


def odds_ratio(pairs: Pairs) -> float | None:
    """The Mantel–Haenszel odds ratio of success over families; None where nothing tells it.

    Source: Mantel and Haenszel, Statistical aspects of the analysis of data from retrospective
    studies of disease (1959). Scenes count as if they were not paired.
    """
    above = below = 0.0
    for family in np.unique(pairs.families):
        of = pairs.families == family
        n, wins, others = int(np.sum(of)), int(pairs.first[of].sum()), int(pairs.second[of].sum())
        above += wins * (n - others) / (2 * n)
        below += others * (n - wins) / (2 * n)
    if below == 0.0:
        return math.inf if above > 0.0 else None
    return above / below


def by_family(pairs: Pairs) -> dict[str, float]:
    """The difference in success rates in each family."""
    return {
        str(family): float(pairs.gains[pairs.families == family].mean())
        for family in dict.fromkeys(pairs.families.tolist())
    }


def without_each_family(pairs: Pairs) -> dict[str, float]:
    """The difference in success rates over all scenes but those of one family."""
    return {
        str(family): float(pairs.gains[pairs.families != family].mean())
        for family in dict.fromkeys(pairs.families.tolist())
        if np.any(pairs.families != family)
    }


def holm(p_values: Sequence[float]) -> list[float]:
    """The p values of a group, corrected for testing them all.

    Source: Holm, A simple sequentially rejective multiple test procedure (1979).
    """
    order = sorted(range(len(p_values)), key=lambda k: p_values[k])
    corrected, least = [0.0] * len(p_values), 0.0
    for rank, k in enumerate(order):
        least = max(least, min(1.0, (len(p_values) - rank) * p_values[k]))
        corrected[k] = least
    return corrected
