"""Options with chances, a conformal set of them, and help where it is not one: deferring.

Nothing here is introspective reasoning by a language model: its part is taken by a vote of the
nearest situations of the past, or by a fitted model.

Source: EVALUATION, IntroPlan; Liang et al., Introspective planning: aligning robots' uncertainty
with inherent task ambiguity (2024); Ren et al., Robots that ask for help (2023).
"""

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Final

from surefetch.common.messages import Choice, Inform
from surefetch.evaluation.policies import introplan_knowledge
from surefetch.evaluation.policies.introplan_chances import CHANCES, STRONG, likely
from surefetch.evaluation.policies.introplan_knowledge import NO_FOLD, Knowledge
from surefetch.evaluation.policies.introplan_situation import (
    GRASP_FIRST,
    GRASP_SECOND,
    LOOK,
    NOT_LISTED,
    OPEN,
    OPTIONS,
    choices,
)
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.tuning import Scalar

TARGET: Final = 0.85
"""Share of episodes in which the set is to hold what is right, as published."""
SCALARS: Final = (
    Scalar("target", (0.7, 0.75, 0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.98, 0.99)),
    Scalar("heeds_not_listed", (0.0, 1.0)),
)
"""Of the strong variant."""


@dataclass
class IntroPlan:
    """Chooses among the options that the conformal set holds."""

    variant: str = STRONG
    target: float = TARGET
    heeds_not_listed: float = 0.0
    """1: also the strong variant asks for help instead of grasping when what is right may not be
    among the options, as published; 0: it grasps."""
    held_out: float = NO_FOLD
    """The fold of development scenes that must not have been learned from."""
    known: Knowledge | None = None
    """None: what ships for the belief that is played with."""
    because: str = field(default="", init=False)
    _view: str | None = field(default=None, init=False)
    _asked_for: str | None = field(default=None, init=False)

    def act(self, now: Observation) -> Choice:
        """What the set of likely options leads to."""
        kept = self._likely(now)
        if self.variant == STRONG:
            option = best_of(kept, heeds_not_listed=bool(self.heeds_not_listed))
        else:
            option = the_only_one(kept)
        chosen = choices(now)[option]
        assert chosen is not None
        self._asked_for = chosen.name if isinstance(chosen, Inform) else None
        return chosen

    def _likely(self, now: Observation) -> list[int]:
        fold = int(self.held_out)
        known = self.known or introplan_knowledge.shipped(now.profile.name)
        p = CHANCES[self.variant](now, self._seen_from(now), known, fold)
        kept = likely(p, known.q_hat(self.variant, self.target, fold))
        chances = ", ".join(f"{OPTIONS[o]} {p[o]:.2f}" for o in range(len(OPTIONS)) if p[o] > 0.0)
        self.because = f"{chances}; left: {', '.join(OPTIONS[o] for o in kept) or 'none'}"
        return kept

    def _seen_from(self, now: Observation) -> str:
        """The view of the latest look; an action that failed led to none."""
        if self._asked_for in now.used:
            self._view = now.cell.inform(self._asked_for).view
        return self._view or now.cell.views[0].name


def the_only_one(kept: Collection[int]) -> int:
    """The option that is left alone; where several are, or none, help is asked for."""
    return next(iter(kept)) if len(kept) == 1 else NOT_LISTED


def best_of(kept: Collection[int], *, heeds_not_listed: bool) -> int:
    """The cheapest look that is left, else the grasp, if only one is; else help is asked for."""
    for look in (LOOK, OPEN):
        if look in kept:
            return look
    grasps = [option for option in (GRASP_FIRST, GRASP_SECOND) if option in kept]
    doubtful = len(grasps) != 1 or (heeds_not_listed and NOT_LISTED in kept)
    return NOT_LISTED if doubtful else grasps[0]
