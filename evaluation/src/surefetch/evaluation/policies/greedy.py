"""Grasp what is most probable now, at once, if it is probable enough."""

from dataclasses import dataclass

from surefetch.common.messages import Choice, Defer, Grasp
from surefetch.evaluation.policies.observation import Observation


@dataclass(frozen=True)
class Greedy:
    """Takes no information action."""

    at_least: float = 0.0
    """Least belief in the best grasp; below it, defers."""

    def act(self, now: Observation) -> Choice:
        """Grasp the best, or defer."""
        best = next(iter(now.grasps), None)
        if best is None or best.p < self.at_least:
            return Defer()
        return Grasp(track=best.track, relation=best.relation)
