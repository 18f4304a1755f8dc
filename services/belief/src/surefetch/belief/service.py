"""Detections in; tracks, belief and conformal set out."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

from surefetch.belief.episode import EpisodeBelief, Rules, rules_of, step
from surefetch.common.errors import Refused
from surefetch.common.messages import BeliefReply, Update
from surefetch.common.parameters import Parameters, check_origin
from surefetch.common.runner import Handle
from surefetch.common.topics import BELIEF, UPDATE

log = logging.getLogger(__name__)

OUT_OF_ORDER: Final = "OUT_OF_ORDER"
ID_REUSED: Final = "ID_REUSED"


Look = tuple[object, ...]
"""What makes two looks the same one."""


@dataclass(frozen=True, eq=False)
class Serving:
    """The episode that is served now: its belief, and every look and its reply by `obs_seq`."""

    episode: str
    belief: EpisodeBelief
    answered: tuple[tuple[Look, BeliefReply], ...] = ()


class BeliefService:
    """Believes one episode at a time. Each look counts once, in order."""

    name = BELIEF
    backend = "joint"

    def __init__(self, parameters_of: Callable[[str], Parameters], cell: str) -> None:
        """`parameters_of` a profile raises BadInput; `cell` is the name in the cell file."""
        self._parameters_of = parameters_of
        self._cell = cell
        self._serving: Serving | None = None

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        """The one topic."""
        return (Handle(UPDATE, self.handle),)

    @property
    def doing(self) -> str:
        """Which episode it believes, and how many looks it has had."""
        serving = self._serving
        return "idle" if serving is None else f"{serving.episode}, {len(serving.answered)} looks"

    def handle(self, update: Update) -> BeliefReply:
        """Believe one more look; a repeated one gets the stored reply.

        Raises:
            Refused: OUT_OF_ORDER, a look is missing or its episode is not the one that is served;
                ID_REUSED, another look came with this number before.
            BadInput: there is no such profile, or its parameters belong to another cell or
                perception.
        """
        serving = self._serving_for(update)
        if update.obs_seq < len(serving.answered):
            return _stored(*serving.answered[update.obs_seq], update)
        belief, reply = step(serving.belief, update)
        _log_dropped(reply)
        self._serving = replace(
            serving, belief=belief, answered=(*serving.answered, (_look(update), reply))
        )
        return reply

    def _serving_for(self, update: Update) -> Serving:
        known = self._serving
        if known is not None and known.episode == update.episode:
            if update.obs_seq > len(known.answered):
                raise _out_of_order(update, expected=len(known.answered))
            return known
        if update.obs_seq != 0 or update.step != 0:
            raise _out_of_order(update, expected=0)
        return Serving(update.episode, EpisodeBelief(self._rules(update)))

    def _rules(self, update: Update) -> Rules:
        parameters = self._parameters_of(update.profile)
        check_origin(parameters, cell=self._cell, backend=update.backend)
        return rules_of(parameters, update.asked)


def _stored(answered: Look, reply: BeliefReply, again: Update) -> BeliefReply:
    """The reply, if it is the same look that asks again."""
    if answered != _look(again):
        raise Refused(
            ID_REUSED,
            f"look {again.obs_seq} of episode {again.episode} was another one before; every look "
            f"needs a number of its own",
        )
    return reply


def _look(update: Update) -> Look:
    ids = tuple(d.id for d in update.detections)
    return update.step, update.profile, update.q, update.asked, update.counted, update.covered, ids


def _out_of_order(update: Update, expected: int) -> Refused:
    return Refused(
        OUT_OF_ORDER,
        f"look {update.obs_seq} of episode {update.episode} cannot be believed: look {expected} "
        f"comes first; nothing was changed",
    )


def _log_dropped(reply: BeliefReply) -> None:
    for assigned in reply.assigned:
        if assigned.track is None:
            log.info("%s has no centre and is not tracked", assigned.detection)
