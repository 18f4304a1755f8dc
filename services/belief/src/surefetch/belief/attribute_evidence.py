"""The four answers as evidence on what a track has and where it stands. Pure.

A track has a pattern: which of the asked attributes match, and its relation. Given its pattern,
the answers to it are independent:

    P(answers | m, ρ, q) = Π_u P_u(a_u | m_u, q) · P_mem(a_mem | ρ, q)

The target has all that is named, in its relation. What is not the target has some pattern of
those that uniqueness leaves, and keeps it: its chances are learnt look by look (exact Bayes), so
that what was read once need not be doubted anew.

Tables without a target are other tables (they hold more near-misses), so that the patterns may
have other chances π_A there than beside a target, π_D. With everything that is not the target from
π_A, absence gains over all else by each track's answers Y_i so far

    (Σ_m,ρ π_A(m, ρ) P(Y_i | m, ρ) / Σ_m,ρ π_D(m, ρ) P(Y_i | m, ρ)) ^ w

where w < 1 stands for that the bodies of one table were not chosen independently.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from surefetch.belief.evidence import NOTHING, Known, Seen, Weigh, Weighed
from surefetch.common.answer_tables import (
    ATTRIBUTES,
    AnswerTables,
    Attribute,
    Company,
    DistractorTable,
    Has,
    LabelCounts,
    named_key,
)
from surefetch.common.emission import pooled
from surefetch.common.hypotheses import (
    IDENTITY_LABELS,
    MEMBERSHIP_LABELS,
    RELATIONS,
    AskedRelation,
)
from surefetch.common.messages import Answer, Answers

Array = NDArray[np.float64]

K = TypeVar("K", bound=str)

HAS: Final[tuple[Has, ...]] = ("match", "mismatch")
MATCHES: Final = np.array(list(product((True, False), repeat=len(ATTRIBUTES))))
"""(8, attributes): which match, all first. An attribute that is not asked counts as matching."""
BACK_OFF: Final = 4.0
"""Tracks that the patterns with and without a target together count for."""
NO_COUNTS: Final[LabelCounts] = (0, 0, 0)


@dataclass(frozen=True, eq=False)
class AttributeEvidence:
    """Latent patterns under the answers.

    What is known of a track is the chance of each of the (8, 2) patterns if it is not the target:
    beside a target and, where that is told apart, without one.
    """

    tables: AnswerTables
    asked: AskedRelation
    company: Company | None = None
    """None: absence gains nothing."""

    def under(self, q: str) -> Weigh:
        """P(answers | pattern, q), with the tables read once."""
        identity = {u: _pooled(self.tables.identity[u], q, HAS) for u in ATTRIBUTES}
        membership = _pooled(self.tables.membership, q, RELATIONS)

        def weigh(seen: Seen, known: Known) -> Weighed:
            assert seen.answers is not None, "an observation without answers never counts"
            by_pattern = _likelihood(seen.answers, identity, membership)
            joint = self._before(seen.answers, known) * by_pattern
            as_distractor = joint.sum(axis=(1, 2))
            return Weighed(
                np.append(by_pattern[0], as_distractor[0]),
                tuple((joint / as_distractor[:, None, None]).ravel().tolist()),
                self._absence(as_distractor),
            )

        return weigh

    def _before(self, answers: Answers, known: Known) -> Array:
        """Chances of the patterns of a distractor before this observation: (1 or 2, 8, 2)."""
        if known != NOTHING:
            return np.array(known).reshape(-1, len(MATCHES), len(RELATIONS))
        named = _named(answers)
        everywhere = distractor_patterns(self.tables, self.asked, named)
        if self.company is None:
            return everywhere[None]
        counted = _counts(self.tables.distractors, self.asked, named)
        without = _counts(self.company.distractors, self.asked, named)
        beside = np.maximum(counted - without, 0.0)
        return np.stack([_drawn(beside, everywhere), _drawn(without, everywhere)])

    def _absence(self, as_distractor: Array) -> float:
        if self.company is None:
            return 1.0
        return float((as_distractor[1] / as_distractor[0]) ** self.company.weight)


def _likelihood(answers: Answers, identity: dict[Attribute, Array], membership: Array) -> Array:
    """P(answers | m, ρ, q) as (8, relations)."""
    of_matches = np.ones(len(MATCHES))
    for k, u in enumerate(ATTRIBUTES):
        answer: Answer | None = getattr(answers, u)
        if answer is not None:
            by_has = identity[u][:, IDENTITY_LABELS.index(answer.label)]
            of_matches *= np.where(MATCHES[:, k], by_has[0], by_has[1])
    of_relation = membership[:, MEMBERSHIP_LABELS.index(answers.membership.label)]
    likelihood: Array = of_matches[:, None] * of_relation
    return likelihood


def _named(answers: Answers) -> tuple[Attribute, ...]:
    return tuple(u for u in ATTRIBUTES if getattr(answers, u) is not None)


def distractor_patterns(
    tables: AnswerTables, asked: AskedRelation, named: tuple[Attribute, ...]
) -> Array:
    """π_D(m, ρ | asked) as (8, relations), add-one smoothed over the patterns that are possible.

    What is not named counts as matching. What has all that is named in an allowed relation would
    be the target; only where that would leave nothing, when nothing is named, it is possible too.
    """
    unnamed = [k for k, u in enumerate(ATTRIBUTES) if u not in named]
    expressible = np.array([all(row[unnamed]) for row in MATCHES])
    possible = np.repeat(expressible[:, None], len(RELATIONS), axis=1)
    possible[0] = [asked not in ("any", relation) for relation in RELATIONS]
    if not possible.any():
        possible[0] = True
    more = np.where(possible, _counts(tables.distractors, asked, named) + 1.0, 0.0)
    chances: Array = more / more.sum()
    return chances


def _counts(table: DistractorTable, asked: AskedRelation, named: tuple[Attribute, ...]) -> Array:
    """N(m, ρ | asked) as (8, relations)."""
    unnamed = [k for k, u in enumerate(ATTRIBUTES) if u not in named]
    expressible = np.array([all(row[unnamed]) for row in MATCHES])
    rows = table.get(asked, {}).get(named_key(named), {})
    none = (0,) * int(expressible.sum())
    counts = np.zeros((len(MATCHES), len(RELATIONS)))
    counts[expressible] = np.array([rows.get(relation, none) for relation in RELATIONS]).T
    return counts


def _drawn(counts: Array, towards: Array) -> Array:
    """Shares of the counts, and of BACK_OFF more that are as expected; possible ones alone."""
    more = np.where(towards > 0.0, counts, 0.0) + BACK_OFF * towards
    chances: Array = more / more.sum()
    return chances


def _pooled(by_q: Mapping[str, Mapping[K, LabelCounts]], q: str, truths: Sequence[K]) -> Array:
    """P(label | truth, q) as (truths, labels)."""

    def table(counts: Mapping[K, LabelCounts]) -> Array:
        return np.array([counts.get(truth, NO_COUNTS) for truth in truths], dtype=np.float64)

    everywhere = sum((table(counts) for counts in by_q.values()), table({}))
    return pooled(table(by_q.get(q, {})), everywhere)
