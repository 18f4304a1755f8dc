"""Walked development scenes to the tables of `answer_tables`: pure counts. Pure."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any, get_args

from surefetch.common.answer_tables import (
    ATTRIBUTES,
    AnswerTables,
    Attribute,
    Company,
    DistractorTable,
    Has,
    LabelCounts,
    attributes_in,
    named_key,
)
from surefetch.common.hypotheses import (
    ASKED,
    IDENTITY_LABELS,
    MEMBERSHIP_LABELS,
    RELATIONS,
    AskedRelation,
    Relation,
)
from surefetch.common.messages import Answers
from surefetch.evaluation.recordings.recording import BodyMatch, RecordingTruth
from surefetch.evaluation.recordings.walk import Look


@dataclass(frozen=True, eq=False)
class AnswerCounts:
    """What was counted over scenes; sums of two are sums of their entries."""

    identity: Counter[tuple[Attribute, str, Has, str]] = field(default_factory=Counter)
    """N(attribute, q, match or mismatch, label)"""
    membership: Counter[tuple[str, Relation, str]] = field(default_factory=Counter)
    """N(q, relation, label)"""
    distractors: Counter[tuple[AskedRelation, str, Relation, tuple[bool, ...]]] = field(
        default_factory=Counter
    )
    """N(asked, named attributes, relation, which of them match)"""
    company: Counter[tuple[AskedRelation, str, Relation, tuple[bool, ...]]] = field(
        default_factory=Counter
    )
    """The part of `distractors` from scenes where the target is absent."""

    def __add__(self, other: "AnswerCounts") -> "AnswerCounts":
        return AnswerCounts(
            self.identity + other.identity,
            self.membership + other.membership,
            self.distractors + other.distractors,
            self.company + other.company,
        )


def count(looks: Sequence[Look], truth: RecordingTruth, asked: AskedRelation) -> AnswerCounts:
    """What one scene contributes, by the bodies under its detections.

    Answers count where they counted in the belief. Of the tracks at the end, all count as
    distractors but those of the target. Detections of no body, and bodies that straddle the
    container's boundary, are left out.

    Args:
        looks: along the sequence that sees the most.
        truth: the scorer's file of the scene.
        asked: the relation that the instruction names.
    """
    counts = AnswerCounts()
    for look in looks:
        for detection, track in _counted(look):
            body = look.bodies[track]
            if body is not None:
                _count_answers(counts, look.q, look.answers[detection], truth.matches[body])
    for body in looks[-1].bodies.values():
        if body is not None and body != truth.target:
            _count_distractor(counts, asked, truth.matches[body])
    if truth.target is None:
        counts.company.update(counts.distractors)
    return counts


def _counted(look: Look) -> Iterable[tuple[str, int]]:
    return (
        (a.detection, a.track)
        for a in look.reply.assigned
        if a.counted and a.track is not None and a.detection in look.answers
    )


def _count_answers(counts: AnswerCounts, q: str, answers: Answers, body: BodyMatch) -> None:
    for u in ATTRIBUTES:
        answer, matches = getattr(answers, u), getattr(body, u)
        if answer is not None and matches is not None:
            counts.identity[u, q, "match" if matches else "mismatch", answer.label] += 1
    if body.relation is not None:
        counts.membership[q, body.relation, answers.membership.label] += 1


def _count_distractor(counts: AnswerCounts, asked: AskedRelation, body: BodyMatch) -> None:
    if body.relation is not None:
        has = {u: getattr(body, u) for u in ATTRIBUTES if getattr(body, u) is not None}
        counts.distractors[asked, named_key(tuple(has)), body.relation, tuple(has.values())] += 1


def tables(counts: AnswerCounts) -> AnswerTables:
    """The counts as a parameter file holds them."""
    return AnswerTables(
        identity={u: _identity(counts, u) for u in ATTRIBUTES},
        membership={
            q: {r: _row(counts.membership, (q, r), MEMBERSHIP_LABELS) for r in RELATIONS}
            for q in sorted({q for q, _, _ in counts.membership})
        },
        distractors=_distractors(counts.distractors),
    )


def company(counts: AnswerCounts, weight: float) -> Company:
    """What stands on tables without a target, as a parameter file holds it."""
    return Company(distractors=_distractors(counts.company), weight=weight)


def _identity(counts: AnswerCounts, u: Attribute) -> dict[str, dict[Has, LabelCounts]]:
    return {
        q: {has: _row(counts.identity, (u, q, has), IDENTITY_LABELS) for has in get_args(Has)}
        for q in sorted({q for attribute, q, _, _ in counts.identity if attribute == u})
    }


def _row(counts: Counter[Any], truth: tuple[str, ...], labels: Sequence[str]) -> LabelCounts:
    first, second, third = (counts[(*truth, label)] for label in labels)
    return first, second, third


def _distractors(
    counted: Counter[tuple[AskedRelation, str, Relation, tuple[bool, ...]]],
) -> DistractorTable:
    return {
        asked: {
            key: {
                r: tuple(
                    counted[asked, key, r, has]
                    for has in product((True, False), repeat=len(attributes_in(key)))
                )
                for r in RELATIONS
            }
            for key in sorted({key for a, key, _, _ in counted if a == asked})
        }
        for asked in ASKED
    }
