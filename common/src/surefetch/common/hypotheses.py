"""Names of hypotheses, observations and classes, spelled as in the golden cases."""

from typing import Final, Literal

UNOBS: Final = "unobs"
ABS: Final = "abs"

Relation = Literal["inside", "outside"]
AskedRelation = Literal["inside", "outside", "any"]
ASKED: Final[tuple[AskedRelation, ...]] = ("inside", "outside", "any")
RELATIONS: Final[tuple[Relation, ...]] = ("inside", "outside")
NEEDS_OPEN: Final[frozenset[Relation]] = frozenset({"inside"})
"""Relations in which a track can be grasped from an open container only."""

OBSERVATIONS: Final = ("MI", "MO", "MU", "mismatch", "UI", "UO", "UU")
CLASSES: Final = ("target_inside", "target_outside", "distractor")

IDENTITY_LABELS: Final = ("supported", "contradicted", "unobservable")
MEMBERSHIP_LABELS: Final = ("inside", "outside", "unknown")


def tracked(track: int, relation: str) -> str:
    """The name of the hypothesis that this track is the target and stands so: ``"3:inside"``."""
    return f"{track}:{relation}"


def parse_tracked(hypothesis: str) -> tuple[int, str] | None:
    """Track and relation of a tracked hypothesis; None for `unobs` and `abs`."""
    if hypothesis in (UNOBS, ABS):
        return None
    track, relation = hypothesis.split(":")
    return int(track), relation
