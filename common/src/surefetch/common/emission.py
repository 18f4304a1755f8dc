"""How likely each observation is, given the viewing condition and what the track is. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.hypotheses import CLASSES, OBSERVATIONS

Array = NDArray[np.float64]
Counts = Mapping[str, Mapping[str, Sequence[int]]]
"""``counts[q][class]``: how often each of the seven observations was seen. May have gaps."""


@dataclass(frozen=True, eq=False)
class Emission:
    """The observation model E(y | q, c) with add-one smoothing, pooled over views where thin.

    With ``pooled_views`` every viewing condition gets the view-pooled distribution.

    Source: paper, sec:emission-model, eq:pooled-emission.
    """

    counts: Counts
    pooled_views: bool = False

    def likelihood(self, q: str) -> Array:
        """E(y | q, c) as (classes, observations), in the orders of `hypotheses`."""
        everywhere = sum((_table(view) for view in self.counts.values()), _table({}))
        if self.pooled_views:
            return smoothed(everywhere)
        return pooled(_table(self.counts.get(q, {})), everywhere)


def pooled(here: Array, everywhere: Array) -> Array:
    """Distributions from counts of one viewing condition, leaning on all views where they are few.

    Args:
        here: (classes, labels) counts under this condition.
        everywhere: the same over all conditions.

    Source: paper, eq:pooled-emission.
    """
    n = here.sum(axis=1, keepdims=True)
    w = n / (n + 1.0)
    mixed: Array = w * smoothed(here) + (1.0 - w) * smoothed(everywhere)
    return mixed


def smoothed(counts: Array) -> Array:
    """Rows of counts to distributions, one added to every count."""
    more: Array = (counts + 1.0) / (counts.sum(axis=1, keepdims=True) + counts.shape[1])
    return more


def _table(by_class: Mapping[str, Sequence[int]]) -> Array:
    """Counts of one viewing condition as (classes, observations); zeros where unseen."""
    none = (0,) * len(OBSERVATIONS)
    return np.array([by_class.get(name, none) for name in CLASSES], dtype=np.float64)
