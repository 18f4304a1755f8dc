"""The joint belief over which track is the target, how it stands, and whether it is there."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.hypotheses import ABS, RELATIONS, UNOBS, tracked

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class JointBelief:
    """Probabilities by hypothesis. Tracks stand in increasing id, that is, in order of age.

    Source: paper, eq:hypothesis-space.
    """

    tracks: tuple[int, ...]
    p_tracked: Array
    """(tracks, relations)"""
    p_unobs: float
    p_abs: float

    @classmethod
    def read(cls, belief: Mapping[str, float]) -> "JointBelief":
        """A belief from names and numbers. Raises KeyError for a missing hypothesis."""
        ids = {z.split(":")[0] for z in belief if z not in (UNOBS, ABS)}
        tracks = tuple(sorted(int(i) for i in ids))
        p = [[belief[tracked(i, relation)] for relation in RELATIONS] for i in tracks]
        return cls(
            tracks, np.array(p, dtype=np.float64).reshape(-1, len(RELATIONS)),
            belief[UNOBS], belief[ABS],
        )  # fmt: skip

    def named(self) -> dict[str, float]:
        """Names and numbers: tracks by id, then unobs, then abs."""
        by_name = {
            tracked(i, relation): float(p)
            for i, row in zip(self.tracks, self.p_tracked, strict=True)
            for relation, p in zip(RELATIONS, row, strict=True)
        }
        return {**by_name, UNOBS: float(self.p_unobs), ABS: float(self.p_abs)}


def normalised(belief: JointBelief) -> JointBelief:
    """The same proportions, with masses that sum to 1."""
    total = belief.p_tracked.sum() + belief.p_unobs + belief.p_abs
    return JointBelief(
        belief.tracks, belief.p_tracked / total, belief.p_unobs / total, belief.p_abs / total
    )


def factorized(p_tracked: Array) -> Array:
    """b(c, r) as b(c)·ρ(r), one relation distribution ρ shared by all tracks.

    Works on any leading axes: (…, tracks, relations), normalised or not.

    Source: golden cases, option `factorized`.
    """
    of_relation = p_tracked.sum(axis=-2, keepdims=True)
    total = of_relation.sum(axis=-1, keepdims=True)
    rho = np.divide(of_relation, total, out=np.zeros_like(of_relation), where=total > 0.0)
    product: Array = p_tracked.sum(axis=-1, keepdims=True) * rho
    return product
