"""What a scene of a family must hold: who is there, who hides, what the sentence says (pure).

A plan is drawn once for a seed and kept over all attempts to lay it out, so that rejecting layouts
cannot shift the rates below. Source: the families' table of the scenario generator.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeVar

import numpy as np

from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import AskedRelation, Relation
from surefetch.common.messages import Face, MarkingKind, Shape
from surefetch.evaluation.appearance import COLORS
from surefetch.evaluation.splits import FAMILIES

SHAPES: Final[tuple[Shape, ...]] = ("cube", "block", "cylinder", "ball", "hexagonal prism")
WIDE_SHAPES: Final[tuple[Shape, ...]] = ("cylinder", "hexagonal prism")
MARKINGS: Final[tuple[MarkingKind, ...]] = ("plain", "stripe", "dot", "cross")
FACES: Final[tuple[Face, ...]] = ("front", "right", "top")
READABLE_FIRST: Final[tuple[Face, ...]] = ("top", "top", "front")
"""Faces that the first view reads."""
MARKS: Final[tuple[MarkingKind, ...]] = MARKINGS[1:]
ATTRIBUTES: Final = ("color", "shape", "marking")
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
OTHERS: Final = {
    "visible": (3, 6),
    "partial": (3, 5),
    "covered": (3, 6),
    "ambiguous": (3, 5),
    "absent": (3, 6),
}
"""Fewest and most bodies besides the target."""
THIRDS: Final = ((0.45, 0.60), (0.60, 0.80), (0.80, 0.95))
"""Of the target's occlusion from the first view, in the family `partial`."""

T = TypeVar("T")

Role = Literal["target", "twin", "near miss", "filler", "wide", "occluder"]
Hiding = Literal["none", "screen", "corner", "body", "beside container"]
"""In front of a body: nothing, a screen, screens in front and to the right, another body; or the
body stands so near the container that it seems to belong to it."""


@dataclass(frozen=True)
class Attributes:
    """What a sentence can say of a body."""

    color: str
    shape: Shape
    marking: MarkingKind

    def shared(self, other: "Attributes") -> int:
        """How many of the three are the same."""
        return sum(getattr(self, name) == getattr(other, name) for name in ATTRIBUTES)


@dataclass(frozen=True)
class Part:
    """One body of a plan."""

    role: Role
    attributes: Attributes
    relation: Relation
    face: Face
    """The face that is marked; of a plain body the face on which its near-misses are marked."""
    hiding: Hiding = "none"
    hidden: tuple[float, float] = (0.0, 0.0)
    """Between which shares it is hidden from the first view, where something hides it."""


@dataclass(frozen=True)
class Plan:
    """One scene, before anything has a place."""

    family: str
    asked: Attributes
    """The target's; in an absent scene, of what is not there."""
    named: tuple[str, ...]
    """Which of them the sentence names."""
    relation_asked: AskedRelation
    relation: Relation | None
    """The target's; None when it is absent."""
    covered: bool
    stratum: str
    parts: tuple[Part, ...]
    tray: bool = False
    """The container must be a tray."""
    empty_screen: bool = False
    """A screen that hides nothing but table."""
    clear_right: bool = True
    """Whether the right view shows that what stands beside the container is outside it."""

    def matches(self, attributes: Attributes) -> bool:
        """Whether the sentence's attributes fit this body."""
        return all(getattr(attributes, name) == getattr(self.asked, name) for name in self.named)


def draw_plan(family: str, rng: np.random.Generator) -> Plan:
    """What a scene of this family holds. Raises BadInput for an unknown family."""
    if family not in FAMILIES:
        raise BadInput(f'there is no family "{family}".\n  Families: {", ".join(FAMILIES)}')
    return PLANNERS[family](rng)


def _chance(rng: np.random.Generator, p: float) -> bool:
    return bool(rng.random() < p)


def _one(rng: np.random.Generator, values: Sequence[T]) -> T:
    return values[int(rng.integers(len(values)))]


def _attributes(rng: np.random.Generator, markings: Sequence[MarkingKind] = MARKINGS) -> Attributes:
    return Attributes(_one(rng, tuple(COLORS)), _one(rng, SHAPES), _one(rng, markings))


def _named(rng: np.random.Generator, always: tuple[str, ...] = ()) -> tuple[str, ...]:
    """All three attributes in 70 % of the sentences, else two of them."""
    if _chance(rng, P_ALL_NAMED):
        return ATTRIBUTES
    dropped = _one(rng, [name for name in ATTRIBUTES if name not in always])
    return tuple(name for name in ATTRIBUTES if name != dropped)


def _relation_asked(
    family: str, relation: Relation | None, rng: np.random.Generator
) -> AskedRelation:
    """The relation that the sentence names; of an absent target either, alike often."""
    if not _chance(rng, P_RELATION_NAMED[family]):
        return "any"
    sides: tuple[Relation, ...] = ("inside", "outside")
    return relation if relation is not None else _one(rng, sides)


def _near_miss(asked: Attributes, differs: str, rng: np.random.Generator) -> Attributes:
    """Shares two attributes; the third is often one that is easily confused."""
    match differs:
        case "color":
            return replace(asked, color=_another(asked.color, tuple(COLORS), rng))
        case "shape":
            return replace(asked, shape=_another(asked.shape, SHAPES, rng))
        case _:
            return replace(asked, marking=_another(asked.marking, MARKINGS, rng))


def _another(value: T, pool: Sequence[T], rng: np.random.Generator) -> T:
    hard = [other for other in pool if other in HARD_PAIRS.get(str(value), ())]
    others = [other for other in pool if other != value]
    return _one(rng, hard if hard and _chance(rng, P_HARD_PAIR) else others)


def _filler(
    asked: Attributes, rng: np.random.Generator, shapes: Sequence[Shape] = SHAPES
) -> Attributes:
    """Shares one attribute at most, so that it is no near-miss."""
    while True:
        drawn = replace(_attributes(rng), shape=_one(rng, shapes))
        if drawn.shared(asked) <= 1:
            return drawn


def _fillers(
    asked: Attributes, n: int, n_others: int, p_inside: float, rng: np.random.Generator
) -> tuple[Part, ...]:
    """Distractors; one in ten of all that are no target is too wide for the hand."""
    wide = n > 0 and _chance(rng, P_WIDE * n_others)
    parts = [Part("wide", _filler(asked, rng, WIDE_SHAPES), "outside", "top")] if wide else []
    while len(parts) < n:
        relation: Relation = "inside" if _chance(rng, p_inside) else "outside"
        parts.append(Part("filler", _filler(asked, rng), relation, _one(rng, FACES)))
    return tuple(parts)


def _visible(rng: np.random.Generator) -> Plan:
    """The first view shows everything that decides."""
    asked, named = _attributes(rng), _named(rng)
    relation: Relation = "inside" if _chance(rng, 0.25) else "outside"
    covered = relation == "outside" and _chance(rng, 0.15 / 0.75)
    n = int(rng.integers(OTHERS["visible"][0], OTHERS["visible"][1] + 1))
    face: Face = "top" if relation == "inside" else _one(rng, READABLE_FIRST)
    misses = tuple(
        Part("near miss", _near_miss(asked, _one(rng, named), rng), "outside", face)
        for _ in range(int(rng.integers(1, 3)))
    )
    fillers = _fillers(asked, n - len(misses), n, 0.0 if covered else 0.2, rng)
    if covered and _chance(rng, 0.5):
        fillers = _one_inside(fillers)
    return Plan(
        "visible",
        asked,
        named,
        _relation_asked("visible", relation, rng),
        relation,
        covered,
        relation,
        (Part("target", asked, relation, face), *misses, *fillers),
        tray=relation == "inside",
    )


def _one_inside(fillers: tuple[Part, ...]) -> tuple[Part, ...]:
    """The last distractor that fits lies in the container."""
    for k in reversed(range(len(fillers))):
        if fillers[k].role == "filler":
            return (*fillers[:k], replace(fillers[k], relation="inside"), *fillers[k + 1 :])
    return fillers


def _one_in_front(fillers: tuple[Part, ...]) -> tuple[Hiding, tuple[Part, ...]]:
    """The first distractor with a flat top stands in front of the target; else a screen does."""
    for k, part in enumerate(fillers):
        if part.role == "filler" and part.attributes.shape not in ("ball", "cube"):
            front = replace(part, role="occluder", relation="outside")
            return "body", (*fillers[:k], front, *fillers[k + 1 :])
    return "screen", fillers


def _partial(rng: np.random.Generator) -> Plan:
    """The first view shows too little of the target; its near-misses differ out of sight."""
    asked, named = _attributes(rng, MARKS), _named(rng, ("marking",))
    stratum = str(rng.choice(["right", "close_high", "both"], p=[0.45, 0.30, 0.25]))
    third = _one(rng, THIRDS)
    covered = _chance(rng, 0.15)
    n = int(rng.integers(OTHERS["partial"][0], OTHERS["partial"][1] + 1))
    face: Face = "right" if stratum == "right" else "top"
    hiding: Hiding = {"right": "screen", "close_high": "corner", "both": "screen"}[stratum]  # type: ignore[assignment]
    if stratum == "right" and third != THIRDS[2] and _chance(rng, 0.5):
        hiding = "body"
    misses = tuple(
        Part(
            "near miss",
            _near_miss(asked, "marking", rng),
            "outside",
            face,
            "none" if face == "right" else hiding,
            (0.3, 0.88),
        )
        for _ in range(int(rng.integers(1, 3)))
    )
    fillers = _fillers(asked, n - len(misses), n, 0.0 if covered else 0.2, rng)
    if hiding == "body":
        hiding, fillers = _one_in_front(fillers)
    if covered and _chance(rng, 0.5):
        fillers = _one_inside(fillers)
    return Plan(
        "partial",
        asked,
        named,
        _relation_asked("partial", "outside", rng),
        "outside",
        covered,
        stratum,
        (Part("target", asked, "outside", face, hiding, third), *misses, *fillers),
    )


def _covered(rng: np.random.Generator) -> Plan:
    """The target lies under the lid."""
    asked, named = _attributes(rng), _named(rng)
    n = int(rng.integers(OTHERS["covered"][0], OTHERS["covered"][1] + 1))
    face: Face = _one(rng, ("top", "top", "top", "front"))
    misses = [
        Part("near miss", _near_miss(asked, _one(rng, named), rng), "inside", face),
        Part("near miss", _near_miss(asked, _one(rng, named), rng), "outside", face),
    ]
    twins = [Part("twin", asked, "outside", face)] if _chance(rng, 0.5) else []
    fillers = _fillers(asked, n - len(misses) - len(twins), n, 0.2, rng)
    return Plan(
        "covered",
        asked,
        named,
        _relation_asked("covered", "inside", rng),
        "inside",
        True,
        "twin" if twins else "no twin",
        (Part("target", asked, "inside", face), *twins, *misses, *fillers),
    )


def _ambiguous(rng: np.random.Generator) -> Plan:
    """Two that fit every word but the relation."""
    asked, named = _attributes(rng), _named(rng)
    relation: Relation = "inside" if _chance(rng, 0.5) else "outside"
    covered = _chance(rng, 0.25)
    n = int(rng.integers(OTHERS["ambiguous"][0], OTHERS["ambiguous"][1] + 1))
    face: Face = "top"
    inside = Part("target" if relation == "inside" else "twin", asked, "inside", face)
    outside = Part(
        "target" if relation == "outside" else "twin", asked, "outside", face, "beside container"
    )
    misses = [
        Part("near miss", _near_miss(asked, _one(rng, named), rng), "inside", face),
        Part("near miss", _near_miss(asked, _one(rng, named), rng), "outside", face),
    ]
    pair = (inside, outside) if relation == "inside" else (outside, inside)
    fillers = _fillers(asked, n - 1 - len(misses), n, 0.0, rng)
    return Plan(
        "ambiguous",
        asked,
        named,
        _relation_asked("ambiguous", relation, rng),
        relation,
        covered,
        f"{relation}{', covered' if covered else ''}",
        (*pair, *misses, *fillers),
        clear_right=_chance(rng, 0.5),
    )


def _absent(rng: np.random.Generator) -> Plan:
    """What is asked for is not there, though it seems to be."""
    asked, named = _attributes(rng), _named(rng, ("marking",))
    relation_asked = _relation_asked("absent", None, rng)
    covered = _chance(rng, 0.4)
    twin_inside = relation_asked == "outside"
    p_twin = 0.0 if relation_asked == "any" or (covered and twin_inside) else 0.3 / 0.8
    has_twin = _chance(rng, p_twin)
    n = int(rng.integers(OTHERS["absent"][0], OTHERS["absent"][1] + 1))
    n_misses = int(rng.integers(2, min(4, n - has_twin) + 1))
    parts = [_hard_near_miss(asked, covered, relation_asked, rng)]
    for _ in range(n_misses - 1):
        relation: Relation = "outside"
        if relation_asked == "inside" and not covered and _chance(rng, 0.6):
            relation = "inside"
        face: Face = "top" if relation == "inside" else _one(rng, READABLE_FIRST)
        parts.append(Part("near miss", _near_miss(asked, _one(rng, named), rng), relation, face))
    if has_twin:
        parts.append(Part("twin", asked, "inside" if twin_inside else "outside", "top"))
    fillers = _fillers(asked, n - len(parts), n, 0.0 if covered else 0.2, rng)
    return Plan(
        "absent",
        asked,
        named,
        relation_asked,
        None,
        covered,
        "twin" if has_twin else "no twin",
        (*parts, *fillers),
        empty_screen=_chance(rng, 0.5),
    )


def _hard_near_miss(
    asked: Attributes, covered: bool, relation_asked: AskedRelation, rng: np.random.Generator
) -> Part:
    """One that the first view cannot refute.

    Its other marking is under the lid, behind a screen, or on its right face.
    """
    attributes = _near_miss(asked, "marking", rng)
    if covered and relation_asked != "outside" and _chance(rng, 0.7):
        return Part("near miss", attributes, "inside", "top")
    if _chance(rng, 0.3):
        return Part("near miss", attributes, "outside", "top", "screen", (0.3, 0.6))
    return Part("near miss", attributes, "outside", "right")


PLANNERS: Final[dict[str, Callable[[np.random.Generator], Plan]]] = {
    "visible": _visible,
    "partial": _partial,
    "covered": _covered,
    "ambiguous": _ambiguous,
    "absent": _absent,
}
