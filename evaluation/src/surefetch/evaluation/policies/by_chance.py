"""Any admissible action, each as likely as the others."""

from surefetch.common.messages import Choice, Defer, Inform
from surefetch.evaluation.policies.cheapest_first import eligible
from surefetch.evaluation.policies.observation import Observation
from surefetch.planner import actions


class ByChance:
    """Uniform over what the paper's rules admit."""

    def act(self, now: Observation) -> Choice | None:
        """One of the actions that are open; None when none is."""
        grasp = eligible(now)
        may_defer = actions.may_defer(now.believed.gamma, now.informs)
        choices: list[Choice] = [] if grasp is None else [grasp]
        choices += [Defer()] if may_defer else []
        choices += [Inform(name=row.name) for row in now.informs]
        return choices[int(now.rng.integers(len(choices)))] if choices else None
