"""What a scene must hold before anything has a place: who is there, who hides, what is said.

A plan is drawn once for a seed (`families`) and kept over all attempts to lay it out, so that
rejecting layouts cannot shift the families' rates.
"""

from dataclasses import dataclass
from typing import Final, Literal

from surefetch.common.hypotheses import AskedRelation, Relation
from surefetch.common.messages import Face, MarkingKind, Shape

ATTRIBUTES: Final = ("color", "shape", "marking")

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
    clear_right: bool | None = None
    """Whether the right view shows that what stands beside the container is outside it; None: it
    may or may not."""
    identity_hidden: bool = False
    """In an ambiguous scene: the first view reads the marking of neither the target nor the
    near-miss on its side."""

    def matches(self, attributes: Attributes) -> bool:
        """Whether the sentence's attributes fit this body."""
        return all(getattr(attributes, name) == getattr(self.asked, name) for name in self.named)
