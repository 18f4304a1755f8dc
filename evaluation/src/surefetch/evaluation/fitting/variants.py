"""The belief with one thing taken out: its rules, and episodes believed by them.

Each has a conformal threshold of its own. Source: EVALUATION, ablations A1 to A3.
"""

from dataclasses import dataclass, replace
from typing import Final

import msgspec

from surefetch.belief.episode import EpisodeBelief, Rules, rules_of, step
from surefetch.belief.evidence import Evidence, Weigh
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import BeliefReply, Update
from surefetch.common.parameters import FULL, Parameters

POOLED_VIEWS: Final = "pooled_views"
"""A1: answers count the same from wherever they were given."""
NO_MEMORY: Final = "no_memory"
"""A2: every look starts from the priors, with the tracks that it shows."""
FACTORIZED: Final = "factorized"
"""A3: which track and which relation are believed apart."""
VARIANTS: Final = (FULL, POOLED_VIEWS, NO_MEMORY, FACTORIZED)

ANYWHERE: Final = "anywhere"
"""No viewing condition was ever fitted under this name, so that it gets the pooled numbers."""


@dataclass(frozen=True, eq=False)
class PooledViews:
    """Evidence that does not ask where it was seen from."""

    of: Evidence

    def under(self, _: str) -> Weigh:
        """The same under every viewing condition."""
        return self.of.under(ANYWHERE)


def rules_for(parameters: Parameters, asked: AskedRelation, variant: str, q_hat: float) -> Rules:
    """What one variant of the belief is believed with."""
    model = rules_of(parameters, asked).model
    if variant == POOLED_VIEWS:
        model = replace(model, evidence=PooledViews(model.evidence))
    if variant == FACTORIZED:
        model = replace(model, factorized=True)
    return Rules(model, q_hat)


def remembers(variant: str) -> bool:
    """Whether one look builds on those before."""
    return variant != NO_MEMORY


def believed(
    before: EpisodeBelief, update: Update, variant: str
) -> tuple[EpisodeBelief, BeliefReply]:
    """One step of a variant. Without memory nothing was counted before, so every look counts."""
    if remembers(variant):
        return step(before, update)
    return step(EpisodeBelief(before.rules), msgspec.structs.replace(update, counted=True))
