"""The planner's own decision, whole or with one thing taken out. Source: EVALUATION, ablations."""

from dataclasses import dataclass, field, replace

from surefetch.common.messages import Choice
from surefetch.evaluation.policies.observation import AFTER_GRASP, Observation
from surefetch.planner import profiles
from surefetch.planner.decide import decide
from surefetch.planner.futures import FutureModel
from surefetch.planner.problem import Options, Problem, Solution
from surefetch.planner.search import solve
from surefetch.planner.situation import Errand


@dataclass
class Planned:
    """Exactly what the planner service would do, but for its switches."""

    options: Options = field(default_factory=Options)
    pooled_views: bool = False
    """What is foreseen leans on observations pooled over views."""
    because: str = field(default="", init=False, repr=False, compare=False)

    def act(self, now: Observation) -> Choice | None:
        """The action of the lowest cost."""
        policy = profiles.Policy("replayed", now.profile, lambda p: self._solve(p, now))
        errand = Errand(now.target, AFTER_GRASP, policy, now.parameters, now.cell)
        decision = decide(errand, now.situation)
        self.because = decision.because
        return decision.choice

    def _solve(self, problem: Problem, now: Observation) -> Solution:
        if self.pooled_views:
            pooled = FutureModel(now.parameters.emission(pooled_views=True), problem.future.paired)
            problem = replace(problem, future=pooled)
        return solve(replace(problem, options=self.options))
