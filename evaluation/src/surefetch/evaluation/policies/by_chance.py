"""Any admissible action, each as likely as the others."""

from surefetch.common.messages import Choice
from surefetch.evaluation.policies.decision import gated
from surefetch.evaluation.policies.observation import Observation


class ByChance:
    """Uniform over what the planner's rules admit."""

    def act(self, now: Observation) -> Choice | None:
        """One of the actions that are open; None when none is."""
        choices = gated(now)
        return choices[int(now.rng.integers(len(choices)))] if choices else None
