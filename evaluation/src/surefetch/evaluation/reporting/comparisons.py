"""The pre-declared comparisons, tested and corrected within their groups. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.reporting import pairs, plan
from surefetch.evaluation.reporting.pairs import Pairs, paired
from surefetch.evaluation.reporting.plan import Group, Key

Played = Mapping[Key, Sequence[EpisodeResult]]
Interval = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Difference:
    """What separates two policies on the same scenes; the first less the second."""

    pairs: Pairs
    success: Interval
    """95 % of the difference in success rates, resampled within families."""
    success_bound: float
    """Lower, one-sided 95 %."""
    p_worse: float
    """Of the first being worse by the margin or more."""
    wrong_bound: float
    """Upper, one-sided 95 %, of the difference in rates of wrong objects."""
    cost: Interval
    """95 % of the difference in mean realised cost."""
    p_cost: float
    """Two-sided, of equal mean realised cost."""

    @property
    def gain(self) -> float:
        """Difference in success rates."""
        return float(self.pairs.gains.mean())

    @property
    def extra_cost(self) -> float:
        """Difference in mean realised cost."""
        return float(self.pairs.extra_cost.mean())


@dataclass(frozen=True, eq=False)
class Comparison:
    """One test of a group. Where the policies were not both played, all but the names is None."""

    group: Group
    second: Key
    difference: Difference | None
    p: float | None
    """Of the group's test, by itself."""
    p_holm: float | None
    """Corrected for the tests of the group, those without data among them."""

    @property
    def holds(self) -> bool | None:
        """Whether the first is better as the group's test has it; None: not known.

        Only where the corrected p is below the level and the difference has the right sign.
        """
        if self.difference is None or self.p_holm is None:
            return None
        better = (
            self.difference.gain > 0.0
            if self.group.test == "success"
            else self.difference.extra_cost < 0.0
        )
        return better and self.p_holm < plan.LEVEL


def difference(first: Sequence[EpisodeResult], second: Sequence[EpisodeResult]) -> Difference:
    """Two policies' episodes compared; the same numbers every time."""
    both = paired(first, second)
    gains = _means(both, both.gains)
    wrong = _means(both, both.extra_wrong)
    costs = _means(both, both.extra_cost)
    return Difference(
        pairs=both,
        success=pairs.interval(gains),
        success_bound=pairs.one_sided(gains)[0],
        p_worse=pairs.p_worse(gains, plan.MARGIN),
        wrong_bound=pairs.one_sided(wrong)[1],
        cost=pairs.interval(costs),
        p_cost=pairs.p_sign_flip(both.extra_cost, plan.DRAWS, np.random.default_rng(plan.SEED)),
    )


def compare(played: Played, group: Group) -> list[Comparison]:
    """All comparisons of a group.

    A test without data counts as the least significant one, so that leaving a policy out makes no
    other p smaller.
    """
    first = played.get(group.first)
    found: list[Difference | None] = []
    for key in group.against:
        second = played.get(key)
        found.append(None if first is None or second is None else difference(first, second))
    p_values = [None if one is None else _p(one, group) for one in found]
    corrected = pairs.holm([1.0 if p is None else p for p in p_values])
    return [
        Comparison(group, key, one, p, None if p is None else holm)
        for key, one, p, holm in zip(group.against, found, p_values, corrected, strict=True)
    ]


def _p(found: Difference, group: Group) -> float:
    """Of "not worse and cheaper" both parts must hold: the larger p.

    Source: Berger, Multiparameter hypothesis testing and acceptance sampling (1982).
    """
    if group.test == "success":
        return found.pairs.p_mcnemar
    return max(found.p_worse, found.p_cost)


def _means(both: Pairs, values: pairs.Floats) -> pairs.Floats:
    rng = np.random.default_rng(plan.SEED)
    return pairs.resampled_means(values, both.families, plan.DRAWS, rng)
