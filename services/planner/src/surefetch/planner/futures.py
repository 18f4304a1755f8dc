"""What may be observed after an action: E_fut for every track and symbol. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import InformRow
from surefetch.common.emission import Emission
from surefetch.common.hypotheses import CLASSES, OBSERVATIONS

Array = NDArray[np.float64]
PairedCounts = Mapping[str, Mapping[str, Mapping[str, Sequence[int]]]]
"""N(a, y0, c, y) as ``[action][y0][class]``; may have gaps."""


@dataclass(frozen=True, eq=False)
class FutureModel:
    """The future-observation model E_fut(y | a, y0, c).

    Source: paper, eq:paired-future-emission.
    """

    emission: Emission
    paired: PairedCounts

    def likelihood(self, row: InformRow, y0: str | None) -> Array:
        """E_fut as (classes, observations); E where the combination was never fitted."""
        base = self.emission.likelihood(row.q)
        seen = self.paired.get(row.name, {}).get(y0, {}) if y0 is not None else {}
        none = (0,) * len(OBSERVATIONS)
        counts = np.array([seen.get(name, none) for name in CLASSES], dtype=np.float64)
        mixed: Array = (counts + base) / (counts.sum(axis=1, keepdims=True) + 1.0)
        return mixed


@dataclass(frozen=True, eq=False)
class Outcomes:
    """One hypothetical observation after an action: track i (of n, uniformly) gives symbol y.

    The n tracks are those that a look is foreseen to show one of.

    Beliefs stay unnormalised and are scaled so that the outcome (i, y) changes track i alone:
    every other hypothesis has the distractor likelihood, which is taken out as the weight. Values
    are homogeneous in the belief, so ``V(b) = sum(weight[i, y] * V(b with row i scaled))``.

    Source: paper, eq:future-outcome, eq:future-belief-mixture.
    """

    ratio: Array
    """(tracks, observations, relations): what the masses of track i are multiplied by"""
    weight: Array
    """(tracks, observations): distractor likelihood over the number of tracks"""


def outcomes(model: FutureModel, row: InformRow, y0: Sequence[str | None]) -> Outcomes:
    """What may come of one action for the tracks that it may show one of; at least one.

    `y0` are their latest counted observations.
    """
    by_y0 = {y: model.likelihood(row, y) for y in set(y0)}
    E = np.array([by_y0[y] for y in y0])  # (tracks, classes, observations), distractor last
    ratio = E[:, :-1, :] / E[:, -1:, :]
    return Outcomes(np.ascontiguousarray(ratio.transpose(0, 2, 1)), E[:, -1, :] / len(y0))
