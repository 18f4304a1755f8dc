"""What all families draw alike: near-misses, distractors, which attributes are named (pure)."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final, TypeVar

import numpy as np

from surefetch.common.hypotheses import AskedRelation, Relation
from surefetch.common.messages import Face, MarkingKind, Shape
from surefetch.evaluation.scenes.appearance import COLORS
from surefetch.evaluation.scenes.plan import ATTRIBUTES, Attributes, Part

SHAPES: Final[tuple[Shape, ...]] = ("cube", "block", "cylinder", "ball", "hexagonal prism")
WIDE_SHAPES: Final[tuple[Shape, ...]] = ("cylinder", "hexagonal prism")
MARKINGS: Final[tuple[MarkingKind, ...]] = ("plain", "stripe", "dot", "cross")
FACES: Final[tuple[Face, ...]] = ("front", "right", "top")
MARKS: Final[tuple[MarkingKind, ...]] = MARKINGS[1:]
HARD_PAIRS: Final[dict[str, tuple[str, ...]]] = {
    "red": ("orange",),
    "orange": ("red", "yellow"),
    "yellow": ("orange",),
    "blue": ("purple",),
    "purple": ("blue",),
    "cube": ("block",),
    "block": ("cube",),
    "cylinder": ("hexagonal prism",),
    "hexagonal prism": ("cylinder",),
}
P_HARD_PAIR: Final = 0.5
P_ALL_NAMED: Final = 0.7
P_WIDE: Final = 0.1
"""Of a distractor: wider than the hand can open."""
P_RELATION_NAMED: Final = {
    "visible": 0.4,
    "partial": 0.3,
    "covered": 1.0,
    "ambiguous": 1.0,
    "absent": 0.7,
}

T = TypeVar("T")


def chance(rng: np.random.Generator, p: float) -> bool:
    return bool(rng.random() < p)


def one(rng: np.random.Generator, values: Sequence[T]) -> T:
    return values[int(rng.integers(len(values)))]


def attributes(rng: np.random.Generator, markings: Sequence[MarkingKind] = MARKINGS) -> Attributes:
    return Attributes(one(rng, tuple(COLORS)), one(rng, SHAPES), one(rng, markings))


def name_some(rng: np.random.Generator, always: tuple[str, ...] = ()) -> tuple[str, ...]:
    """All three attributes in 70 % of the sentences, else two of them."""
    if chance(rng, P_ALL_NAMED):
        return ATTRIBUTES
    dropped = one(rng, [name for name in ATTRIBUTES if name not in always])
    return tuple(name for name in ATTRIBUTES if name != dropped)


def relation_asked_in(
    family: str, relation: Relation | None, rng: np.random.Generator
) -> AskedRelation:
    """The relation that the sentence names; of an absent target either, alike often."""
    if not chance(rng, P_RELATION_NAMED[family]):
        return "any"
    sides: tuple[Relation, ...] = ("inside", "outside")
    return relation if relation is not None else one(rng, sides)


def near_miss(asked: Attributes, differs: str, rng: np.random.Generator) -> Attributes:
    """Shares two attributes; the third is often one that is easily confused."""
    match differs:
        case "color":
            return replace(asked, color=another(asked.color, tuple(COLORS), rng))
        case "shape":
            return replace(asked, shape=another(asked.shape, SHAPES, rng))
        case _:
            return replace(asked, marking=another(asked.marking, MARKINGS, rng))


def another(value: T, pool: Sequence[T], rng: np.random.Generator) -> T:
    hard = [other for other in pool if other in HARD_PAIRS.get(str(value), ())]
    others = [other for other in pool if other != value]
    return one(rng, hard if hard and chance(rng, P_HARD_PAIR) else others)


def filler(
    asked: Attributes, rng: np.random.Generator, shapes: Sequence[Shape] = SHAPES
) -> Attributes:
    """Shares one attribute at most, so that it is no near-miss."""
    while True:
        drawn = replace(attributes(rng), shape=one(rng, shapes))
        if drawn.shared(asked) <= 1:
            return drawn


def fillers_of(
    asked: Attributes, n: int, n_others: int, p_inside: float, rng: np.random.Generator
) -> tuple[Part, ...]:
    """Distractors; one in ten of all that are no target is too wide for the hand."""
    wide = n > 0 and chance(rng, P_WIDE * n_others)
    parts = [Part("wide", filler(asked, rng, WIDE_SHAPES), "outside", "top")] if wide else []
    while len(parts) < n:
        relation: Relation = "inside" if chance(rng, p_inside) else "outside"
        parts.append(Part("filler", filler(asked, rng), relation, one(rng, FACES)))
    return tuple(parts)
