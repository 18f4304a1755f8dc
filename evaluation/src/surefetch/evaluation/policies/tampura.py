"""TAMPURA-like: plan over abstract beliefs whose outcomes are learned by simulation.

Kept are the belief abstraction, plans proposed with optimistic chances, outcomes sampled and
counted batch by batch, value iteration on what was counted, and planning anew at every step. Risk
enters as what a wrong grasp costs. Left out are the continuous parameters of actions, of which
there are none here. Nothing is gated.

Source: Curtis et al., Partially Observable Task and Motion Planning with Uncertainty and Risk
Awareness (2024).
"""

from dataclasses import dataclass, field
from typing import Final

from surefetch.common.messages import Choice
from surefetch.evaluation.policies.decision import foreseen, ungated
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.tampura_learning import Learned
from surefetch.evaluation.policies.tuning import Scalar

SCALARS: Final = (Scalar("confirmed_at", (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.99)),)
DISCOUNT: Final = 0.95
"""As published. Of costs it makes those worth putting off that come anyhow; the undiscounted
variant does not have that."""


@dataclass
class Tampura:
    """Plans anew at every step."""

    confirmed_at: float = 0.9
    """Mass from which a track counts as confirmed."""
    discount: float = DISCOUNT
    most_looks: int | None = None
    """Looks that are planned ahead; None: all that there are."""
    because: str = field(default="", init=False, repr=False, compare=False)

    def act(self, now: Observation) -> Choice | None:
        """The action of the lowest cost in what was learned of the moments to come."""
        learned = Learned(
            foreseen(now), ungated(now), self.confirmed_at, self.discount, self.most_looks
        )
        learned.learn(now.rng)
        choice, cost = learned.best()
        self.because = f"The learned outcomes cost {cost:.3f} on average."
        return choice
