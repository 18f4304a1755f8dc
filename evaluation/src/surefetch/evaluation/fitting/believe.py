"""The belief service's own step as a library, for walks over recorded scenes."""

import math
from collections.abc import Callable

from surefetch.belief.episode import EpisodeBelief, Rules, rules_of, step
from surefetch.belief.evidence import CategoryEvidence
from surefetch.belief.filter import Model
from surefetch.common.emission import Emission
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import BeliefReply, Update
from surefetch.common.parameters import PRINTED, Parameters

BEFORE_FITTING = Rules(Model(CategoryEvidence(Emission({})), PRINTED), math.inf)
"""Tracks and observations do not depend on what is fitted from them."""


def fresh_belief(parameters: Parameters | None) -> Callable[[Update], BeliefReply]:
    """What believes one episode, look by look. None: nothing is fitted yet."""
    belief: EpisodeBelief | None = None

    def believe(update: Update) -> BeliefReply:
        nonlocal belief
        if belief is None:
            belief = EpisodeBelief(_rules(parameters, update.asked))
        belief, reply = step(belief, update)
        return reply

    return believe


def _rules(parameters: Parameters | None, asked: AskedRelation) -> Rules:
    return BEFORE_FITTING if parameters is None else rules_of(parameters, asked)
