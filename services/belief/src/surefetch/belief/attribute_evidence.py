"""The four answers as evidence on what a track has and where it stands. Pure.

A track has a pattern: which of the asked attributes match, and its relation. Given its pattern,
the answers to it are independent:

    P(answers | m, ρ, q) = Π_u P_u(a_u | m_u, q) · P_mem(a_mem | ρ, q)

The target has all that is named, in its relation. What is not the target has some pattern of
those that uniqueness leaves, and keeps it: its chances are learnt look by look (exact Bayes), so
that what was read once need not be doubted anew.
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
NO_COUNTS: Final[LabelCounts] = (0, 0, 0)


@dataclass(frozen=True, eq=False)
class AttributeEvidence:
    """Latent patterns under the answers.

    What is known of a track is the chance of each of the (8, 2) patterns if it is not the target.
    """

    tables: AnswerTables
    asked: AskedRelation

    def under(self, q: str) -> Weigh:
        """P(answers | pattern, q), with the tables read once."""
        identity = {u: _pooled(self.tables.identity[u], q, HAS) for u in ATTRIBUTES}
        membership = _pooled(self.tables.membership, q, RELATIONS)

        def weigh(seen: Seen, known: Known) -> Weighed:
            assert seen.answers is not None, "an observation without answers never counts"
            by_pattern = _likelihood(seen.answers, identity, membership)
            chances = self._before(seen.answers, known)
            joint = chances * by_pattern
            as_distractor = joint.sum()
            return Weighed(
                np.append(by_pattern[0], as_distractor),
                tuple((joint / as_distractor).ravel().tolist()),
            )

        return weigh

    def _before(self, answers: Answers, known: Known) -> Array:
        """Chances of the patterns of a distractor before this observation."""
        if known == NOTHING:
            return distractor_patterns(self.tables, self.asked, _named(answers))
        return np.array(known).reshape(len(MATCHES), len(RELATIONS))


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
    rows = tables.distractors.get(asked, {}).get(named_key(named), {})
    none = (0,) * int(expressible.sum())
    counts = np.zeros(possible.shape)
    counts[expressible] = np.array([rows.get(relation, none) for relation in RELATIONS]).T
    more = np.where(possible, counts + 1.0, 0.0)
    chances: Array = more / more.sum()
    return chances


def _pooled(by_q: Mapping[str, Mapping[K, LabelCounts]], q: str, truths: Sequence[K]) -> Array:
    """P(label | truth, q) as (truths, labels)."""

    def table(counts: Mapping[K, LabelCounts]) -> Array:
        return np.array([counts.get(truth, NO_COUNTS) for truth in truths], dtype=np.float64)

    everywhere = sum((table(counts) for counts in by_q.values()), table({}))
    return pooled(table(by_q.get(q, {})), everywhere)
