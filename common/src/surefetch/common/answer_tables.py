"""Counted answers by what the body under them is, as a parameter file holds them."""

from collections.abc import Sequence
from typing import Annotated, Literal, get_args

import msgspec

from surefetch.common.hypotheses import AskedRelation, Relation

Probability = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
Count = Annotated[int, msgspec.Meta(ge=0)]
LabelCounts = tuple[Count, Count, Count]
"""How often each of a question's three labels was the answer, in their fixed order."""

Attribute = Literal["color", "shape", "marking"]
ATTRIBUTES: tuple[Attribute, ...] = get_args(Attribute)
Has = Literal["match", "mismatch"]
"""Whether a body has the attribute that was asked about."""


class ParameterValue(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A frozen part of a parameter file; unknown and missing keys are errors."""


DistractorTable = dict[AskedRelation, dict[str, dict[Relation, tuple[Count, ...]]]]
"""How many tracks that are not the target have what: ``[asked][named attributes][relation]``, by
which of the named attributes match: all, … , none, the last one changing fastest. The named
attributes stand with a space between, in their fixed order. May have gaps."""


class AnswerTables(ParameterValue, frozen=True):
    """How the four questions are answered, and what stands on tables besides the target."""

    identity: dict[Attribute, dict[str, dict[Has, LabelCounts]]]
    """``[attribute][q][match or mismatch]``. May have gaps."""
    membership: dict[str, dict[Relation, LabelCounts]]
    """``[q][relation of the body]``. May have gaps."""
    distractors: DistractorTable

    def __post_init__(self) -> None:
        missing = set(ATTRIBUTES) - set(self.identity)
        if missing:
            raise ValueError(f"attribute_evidence.identity lacks {', '.join(sorted(missing))}")
        _check(self.distractors)


class Company(ParameterValue, frozen=True):
    """What stands on tables without a target: more of what resembles it than beside a target."""

    distractors: DistractorTable
    """The part of `AnswerTables.distractors` that was counted where the target is absent."""
    weight: Probability
    """Exponent of what a track's company says: of 1, tracks would be independent."""

    def __post_init__(self) -> None:
        _check(self.distractors)


def _check(table: DistractorTable) -> None:
    for by_named in table.values():
        for named, by_relation in by_named.items():
            wanted = 2 ** len(attributes_in(named))
            for row in by_relation.values():
                if len(row) != wanted:
                    raise ValueError(
                        f'distractors of "{named}" need {wanted} counts, not {len(row)}'
                    )


def named_key(named: Sequence[Attribute]) -> str:
    """The key of a set of named attributes."""
    return " ".join(a for a in ATTRIBUTES if a in named)


def attributes_in(key: str) -> tuple[Attribute, ...]:
    """The named attributes of a key. Raises ValueError for any other text."""
    named = tuple(a for a in ATTRIBUTES if a in key.split())
    if named_key(named) != key:
        raise ValueError(f'"{key}" is no list of {", ".join(ATTRIBUTES)} in that order')
    return named
