"""What a policy is told, as the decision problem that the planner would make of it. Pure."""

from dataclasses import replace
from functools import cache

import msgspec

from surefetch.common.hypotheses import ABS
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.common.parameters import Parameters, shipped_parameters
from surefetch.common.policies import DEFAULT_PROFILE
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


def foreseen(now: Observation) -> Problem:
    """The same, and a look may show a target that has no track, whatever the belief knows of that.

    How often it does was counted on development scenes. A belief without that evidence has no such
    number, but who plans with an outcome model of their own would know it: without it nobody ever
    opens a container in which nothing was seen yet.
    """
    if now.parameters.births is not None:
        return problem_of(now)
    known = msgspec.structs.replace(now.parameters, births=_counted().births)
    return problem_of(replace(now, parameters=known))


@cache
def _counted() -> Parameters:
    """The shipped numbers that have it."""
    return shipped_parameters(DEFAULT_PROFILE)


def ungated(now: Observation) -> list[Choice]:
    """Every grasp that instruction, cover and robot allow, deferring, and every open look."""
    grasps = [Grasp(track=grip.track, relation=grip.relation) for grip in now.grasps]
    return [*grasps, Defer(), *(Inform(name=row.name) for row in now.informs)]


def gated(now: Observation) -> list[Choice]:
    """What the planner's rules admit, under the least beliefs that are asked; may be nothing."""
    grasp, informs = eligible(now), now.informs
    p_abs, at_least = now.believed.belief[ABS], now.profile.defer_at_least
    may_defer = actions.may_defer(now.believed.gamma, informs, p_abs, at_least)
    grasps: list[Choice] = [] if grasp is None else [grasp]
    defer = [Defer()] if may_defer else []
    return [*grasps, *defer, *(Inform(name=row.name) for row in informs)]
