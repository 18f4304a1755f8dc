"""How well each kind of marking explains which pixels of a body differ from its own colour. Pure.

Every hypothesis (kind, face, size) predicts for every visible pixel whether it is marked. The cost
of a kind is the number of pixels that its best hypothesis predicts wrongly. A marking that would be
turned away or hidden predicts no marked pixel, as does a plain body: where one can't be told from
the other their costs are equal, and nobody can know. `plain` costs what is seen of a marking.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.geometry import Array
from surefetch.perception.answers.faces import Bools, Surfaces
from surefetch.perception.answers.patches import Patch

PLAIN: Final = "plain"
SIZES: Final[dict[str, Array]] = {
    "stripe": np.linspace(0.22, 0.64, 12),
    "dot": np.linspace(0.52, 0.92, 12),
    "cross": np.linspace(0.12, 0.42, 12),
}
"""Half widths relative to the face that cover about 30 to 60 % of it."""
GRAZING: Final = 0.10
FULL: Final = 0.30
"""Cosines between normal and line of sight from which on a pixel counts at all, and fully."""
MIN_PREDICTED_PX: Final = 20.0
"""On faces that do not carry markings a hypothesis must at least explain this much."""


@dataclass(frozen=True)
class Explanation:
    """The best hypothesis of one kind."""

    cost_px: float
    face: str
    predicted_px: float
    """Marked pixels it predicts"""
    cosine: float
    """Between the face's normal and the line of sight, mean over what it marks; 0 if unseen"""


def weights(surfaces: Surfaces, share: float) -> Array:
    """(n,) how much each pixel counts: little where the surface turns away, nothing beside it.

    Args:
        surfaces: the pixels on the solid.
        share: pixels of the image that one of them stands for.
    """
    turned_to: Array = np.clip((surfaces.cosine - GRAZING) / (FULL - GRAZING), 0.0, 1.0)
    return np.where(surfaces.hit, share * turned_to, 0.0)


def explain(
    marked: Bools, weight: Array, patches: Iterable[Patch], px_m: float
) -> dict[str, Explanation]:
    """The best explanation of each kind.

    Args:
        marked: (n,) pixels that differ from the body's colour.
        weight: (n,) how much each pixel counts.
        patches: the faces.
        px_m: width of a pixel on the body.
    """
    seen = float(weight[marked].sum())
    best = {PLAIN: Explanation(seen, "", 0.0, 0.0)}
    for patch in patches:
        for kind, found in _on(patch, marked, weight, seen, px_m):
            useless = not patch.carrier and found.predicted_px < MIN_PREDICTED_PX
            if useless or (kind in best and best[kind].cost_px <= found.cost_px):
                continue
            best[kind] = found
    return best


def _on(
    patch: Patch, marked: Bools, weight: Array, seen: float, px_m: float
) -> Iterator[tuple[str, Explanation]]:
    w = weight[patch.on]
    label = marked[patch.on].astype(np.float64)
    elsewhere = seen - float(w @ label)
    softness = px_m / np.sqrt(np.clip(patch.cosine, 0.1, 1.0))
    for kind, sizes in SIZES.items():
        depth = _depths(kind, sizes, patch)
        share = np.clip(0.5 + depth / softness, 0.0, 1.0)
        costs = np.abs(share - label) @ w + elsewhere
        k = int(costs.argmin())
        predicted = float(share[k] @ w)
        facing = float(share[k] @ (w * patch.cosine)) / predicted if predicted > 1.0 else 0.0
        yield kind, Explanation(float(costs[k]), patch.name, predicted, facing)


def _depths(kind: str, sizes: Array, patch: Patch) -> Array:
    """(sizes, m) how deep in the marking each pixel lies, in metres; negative outside."""
    half_a, half_b = patch.half_m
    size = sizes[:, None]
    level: Array = (size - np.abs(patch.b)) * half_b
    if kind == "stripe":
        return level
    if kind == "dot":
        middle: Array = (size - np.hypot(patch.a, patch.b)) * np.sqrt(half_a * half_b)
        return middle
    upright: Array = (size - np.abs(patch.a)) * half_a
    return np.maximum(upright, level)
