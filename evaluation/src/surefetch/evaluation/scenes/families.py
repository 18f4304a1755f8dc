"""The five families: what a scene of each holds, at which rates (pure).

Source: the families' table of the scenario generator; changed where its gates asked for it.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import RELATIONS, AskedRelation, Relation
from surefetch.common.messages import Face
from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.scenes.draws import (
    MARKINGS,
    MARKS,
    attributes,
    chance,
    fillers_of,
    name_some,
    near_miss,
    one,
    relation_asked_in,
)
from surefetch.evaluation.scenes.plan import Attributes, Hiding, Part, Plan, Role

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
P_IDENTITY_HIDDEN: Final = 0.75
"""Of `ambiguous`: depth tells inside from outside at once, so that looking once would solve it."""
READABLE_FIRST: Final[tuple[Face, ...]] = ("top", "top", "front")
"""Faces that the first view reads."""


def draw_plan(family: str, rng: np.random.Generator) -> Plan:
    """What a scene of this family holds. Raises BadInput for an unknown family."""
    if family not in FAMILIES:
        raise BadInput(f'there is no family "{family}".\n  Families: {", ".join(FAMILIES)}')
    return PLANNERS[family](rng)


def _visible(rng: np.random.Generator) -> Plan:
    """The first view shows everything that decides."""
    asked, named = attributes(rng), name_some(rng)
    relation: Relation = "inside" if chance(rng, 0.25) else "outside"
    covered = relation == "outside" and chance(rng, 0.15 / 0.75)
    n = int(rng.integers(OTHERS["visible"][0], OTHERS["visible"][1] + 1))
    face: Face = "top" if relation == "inside" else one(rng, READABLE_FIRST)
    misses = tuple(
        Part("near miss", near_miss(asked, one(rng, named), rng), "outside", face)
        for _ in range(int(rng.integers(1, 3)))
    )
    fillers = fillers_of(asked, n - len(misses), n, 0.0 if covered else 0.2, rng)
    if covered and chance(rng, 0.5):
        fillers = _one_inside(fillers)
    return Plan(
        "visible",
        asked,
        named,
        relation_asked_in("visible", relation, rng),
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
    asked, named = attributes(rng, MARKS), name_some(rng, ("marking",))
    stratum = str(rng.choice(["right", "close_high", "both"], p=[0.45, 0.30, 0.25]))
    third = one(rng, THIRDS)
    covered = chance(rng, 0.15)
    n = int(rng.integers(OTHERS["partial"][0], OTHERS["partial"][1] + 1))
    face: Face = "right" if stratum == "right" else "top"
    hiding: Hiding = "corner" if stratum == "close_high" else "screen"
    alike = hiding
    if stratum == "right" and third != THIRDS[2] and chance(rng, 0.5):
        hiding = "body"
    misses = tuple(
        Part(
            "near miss",
            near_miss(asked, "marking", rng),
            "outside",
            face,
            "none" if face == "right" and chance(rng, 0.5) else alike,
            third,
        )
        for _ in range(int(rng.integers(1, 3)))
    )
    fillers = fillers_of(asked, n - len(misses), n, 0.0 if covered else 0.2, rng)
    if hiding == "body":
        hiding, fillers = _one_in_front(fillers)
    if covered and chance(rng, 0.5):
        fillers = _one_inside(fillers)
    return Plan(
        "partial",
        asked,
        named,
        relation_asked_in("partial", "outside", rng),
        "outside",
        covered,
        stratum,
        (Part("target", asked, "outside", face, hiding, third), *misses, *fillers),
    )


def _covered(rng: np.random.Generator) -> Plan:
    """The target lies under the lid."""
    asked, named = attributes(rng), name_some(rng)
    n = int(rng.integers(OTHERS["covered"][0], OTHERS["covered"][1] + 1))
    face: Face = one(rng, ("top", "top", "top", "front"))
    misses = [
        Part("near miss", near_miss(asked, one(rng, named), rng), "inside", face),
        Part("near miss", near_miss(asked, one(rng, named), rng), "outside", face),
    ]
    twins = [Part("twin", asked, "outside", face)] if chance(rng, 0.5) else []
    fillers = fillers_of(asked, n - len(misses) - len(twins), n, 0.2, rng)
    return Plan(
        "covered",
        asked,
        named,
        relation_asked_in("covered", "inside", rng),
        "inside",
        True,
        "twin" if twins else "no twin",
        (Part("target", asked, "inside", face), *twins, *misses, *fillers),
    )


def _ambiguous(rng: np.random.Generator) -> Plan:
    """Two that fit every word but the relation; often the first view does not say which fit."""
    hidden = chance(rng, P_IDENTITY_HIDDEN)
    asked = attributes(rng, MARKS if hidden else MARKINGS)
    named = name_some(rng, ("marking",) if hidden else ())
    relation: Relation = "inside" if chance(rng, 0.5) else "outside"
    covered = chance(rng, 0.25)
    n = int(rng.integers(OTHERS["ambiguous"][0], OTHERS["ambiguous"][1] + 1))
    sides = [_side(side, asked, named, side == relation, hidden, rng) for side in RELATIONS]
    pair = sorted((fits for fits, _ in sides), key=lambda part: part.role != "target")
    misses = [miss for _, miss in sides]
    fillers = fillers_of(asked, n - 1 - len(misses), n, 0.0, rng)
    words = [relation, "covered" if covered else "", "identity hidden" if hidden else ""]
    return Plan(
        "ambiguous",
        asked,
        named,
        relation_asked_in("ambiguous", relation, rng),
        relation,
        covered,
        ", ".join(word for word in words if word),
        (*pair, *misses, *fillers),
        clear_right=_clear_right(asked, hidden and relation == "outside", rng),
        identity_hidden=hidden,
    )


def _clear_right(asked: Attributes, read_there: bool, rng: np.random.Generator) -> bool | None:
    """Half and half; left open where the right view must read the body, and for balls.

    Few places beside a container hide as much of a ball as that.
    """
    clear = chance(rng, 0.5)
    return None if read_there or asked.shape == "ball" else clear


def _side(
    side: Relation,
    asked: Attributes,
    named: tuple[str, ...],
    targets: bool,
    hidden: bool,
    rng: np.random.Generator,
) -> tuple[Part, Part]:
    """What fits the sentence on this side of the wall, and the near-miss that stands there too.

    Where identity is hidden, the target and that near-miss differ in the marking of their right
    faces, which the first view does not read.
    """
    hidden = hidden and targets
    face: Face = "right" if hidden else "top"
    other = near_miss(asked, "marking" if hidden else one(rng, named), rng)
    by: Hiding = "beside container" if side == "outside" else "none"
    role: Role = "target" if targets else "twin"
    return Part(role, asked, side, face, by), Part("near miss", other, side, face)


def _absent(rng: np.random.Generator) -> Plan:
    """What is asked for is not there, though it seems to be."""
    asked, named = attributes(rng), name_some(rng, ("marking",))
    relation_asked = relation_asked_in("absent", None, rng)
    covered = chance(rng, 0.4)
    twin_inside = relation_asked == "outside"
    p_twin = 0.0 if relation_asked == "any" or (covered and twin_inside) else 0.3 / 0.8
    has_twin = chance(rng, p_twin)
    n = int(rng.integers(OTHERS["absent"][0], OTHERS["absent"][1] + 1))
    n_misses = int(rng.integers(2, min(4, n - has_twin) + 1))
    parts = [_hard_near_miss(asked, covered, relation_asked, rng)]
    for _ in range(n_misses - 1):
        relation: Relation = "outside"
        if relation_asked == "inside" and not covered and chance(rng, 0.6):
            relation = "inside"
        face: Face = "top" if relation == "inside" else one(rng, READABLE_FIRST)
        parts.append(Part("near miss", near_miss(asked, one(rng, named), rng), relation, face))
    if has_twin:
        parts.append(Part("twin", asked, "inside" if twin_inside else "outside", "top"))
    fillers = fillers_of(asked, n - len(parts), n, 0.0 if covered else 0.2, rng)
    return Plan(
        "absent",
        asked,
        named,
        relation_asked,
        None,
        covered,
        "twin" if has_twin else "no twin",
        (*parts, *fillers),
        empty_screen=chance(rng, 0.5),
    )


def _hard_near_miss(
    asked: Attributes, covered: bool, relation_asked: AskedRelation, rng: np.random.Generator
) -> Part:
    """One that the first view cannot refute.

    Its other marking is under the lid, behind a screen, or on its right face.
    """
    attributes = near_miss(asked, "marking", rng)
    if covered and relation_asked != "outside" and chance(rng, 0.7):
        return Part("near miss", attributes, "inside", "top")
    if chance(rng, 0.3):
        return Part("near miss", attributes, "outside", "top", "screen", (0.3, 0.6))
    return Part("near miss", attributes, "outside", "right")


PLANNERS: Final[dict[str, Callable[[np.random.Generator], Plan]]] = {
    "visible": _visible,
    "partial": _partial,
    "covered": _covered,
    "ambiguous": _ambiguous,
    "absent": _absent,
}
