"""The belief service's own step as a library, for walks over recorded scenes."""

import math
from collections.abc import Callable

from surefetch.belief.episode import EpisodeBelief, Rules, rules_of, step
from surefetch.belief.filter import Model
from surefetch.common.emission import Emission
from surefetch.common.messages import BeliefReply, Update
from surefetch.common.parameters import PRINTED, Parameters

BEFORE_FITTING = Rules(Model(Emission({}), PRINTED), math.inf)
"""Tracks and observations do not depend on what is fitted from them."""


def fresh_belief(parameters: Parameters | None) -> Callable[[Update], BeliefReply]:
    """What believes one episode, look by look. None: nothing is fitted yet."""
    belief = EpisodeBelief(BEFORE_FITTING if parameters is None else rules_of(parameters))

    def believe(update: Update) -> BeliefReply:
        nonlocal belief
        belief, reply = step(belief, update)
        return reply

    return believe
