"""What a policy is told, as the decision problem that the planner would make of it. Pure."""

from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.evaluation.policies.cheapest_first import eligible
from surefetch.evaluation.policies.observation import AFTER_GRASP, Observation
from surefetch.planner import actions, profiles
from surefetch.planner.decide import problem_of as planners_problem_of
from surefetch.planner.problem import Problem
from surefetch.planner.search import solve
from surefetch.planner.situation import Errand


def problem_of(now: Observation) -> Problem:
    """The planner's own problem of this moment."""
    policy = profiles.Policy("replayed", now.profile, solve)
    errand = Errand(now.target, AFTER_GRASP, policy, now.parameters, now.cell)
    return planners_problem_of(errand, now.situation)


def ungated(now: Observation) -> list[Choice]:
    """Every grasp that instruction, cover and robot allow, deferring, and every open look."""
    grasps = [Grasp(track=grip.track, relation=grip.relation) for grip in now.grasps]
    return [*grasps, Defer(), *(Inform(name=row.name) for row in now.informs)]


def gated(now: Observation) -> list[Choice]:
    """What the paper's rules admit; may be nothing."""
    grasp = eligible(now)
    may_defer = actions.may_defer(now.believed.gamma, now.informs)
    grasps: list[Choice] = [] if grasp is None else [grasp]
    defer = [Defer()] if may_defer else []
    return [*grasps, *defer, *(Inform(name=row.name) for row in now.informs)]
