"""Belief, feasibility and what was done so far → the next action, with every Q value. Pure."""

from dataclasses import dataclass, replace
from typing import Final, cast

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import Relation
from surefetch.common.joint_belief import JointBelief
from surefetch.common.messages import (
    BeliefReply,
    Choice,
    Defer,
    Grasp,
    Inform,
    QValue,
)
from surefetch.common.parameters import Parameters
from surefetch.planner import actions, because
from surefetch.planner.actions import State
from surefetch.planner.futures import FutureModel
from surefetch.planner.problem import Problem, Solution
from surefetch.planner.search import TIE
from surefetch.planner.situation import Errand, Situation

HORIZON: Final = 3
"""Information actions that are looked ahead."""


@dataclass(frozen=True)
class Decision:
    """What to do, and why."""

    choice: Choice | None
    """None: nothing is admissible."""
    q_values: tuple[QValue, ...]
    because: str


def decide(errand: Errand, now: Situation) -> Decision:
    """The action of the lowest cost.

    Where looking is blocked because it failed, and not because there is nothing left to look at,
    abstaining would say more than is known, and is open only where it is with looks to take.
    """
    problem = problem_of(errand, now)
    solution = errand.policy.solve(problem)
    looks = actions.expandable(errand.rows, now.cover, now.used | now.unreachable)
    if any(row.name in now.given_up for row in looks) and not actions.may_defer(
        solution.gamma, looks, problem.belief.p_abs, problem.defer_at_least
    ):
        solution = _without_defer(solution)
    choice = choice_of(solution.chosen)
    return Decision(choice, solution.q_values, because.sentence(errand, now, solution))


def problem_of(errand: Errand, now: Situation) -> Problem:
    """The decision problem of this situation."""
    belief = JointBelief.read(now.believed.belief)
    y0 = {track.id: track.y0 for track in now.believed.tracks}
    parameters = errand.parameters
    return Problem(
        belief=belief,
        y0=tuple(y0[i] for i in belief.tracks),
        state=now.cover,
        used=now.used | now.given_up | now.unreachable,
        feasible=frozenset(v.track for v in now.feasibility.grasps if v.feasible),
        asked=errand.target.relation,
        q_hat=now.believed.q_hat,
        horizon=HORIZON,
        rows=errand.rows,
        future=FutureModel(parameters.emission(), parameters.paired),
        p_remove=parameters.priors.p_remove,
        p_grasp=parameters.priors.p_grasp,
        n_foreseen=errand.policy.profile.n_foreseen,
        defer_at_least=errand.policy.profile.defer_at_least,
        commit_at_least=parameters.commit_at_least,
        p_appears={row.name: _p_appears(parameters, row) for row in errand.rows},
    )


def _p_appears(parameters: Parameters, row: InformRow) -> float:
    """Chance that an information action that succeeds shows a target that had no track."""
    return parameters.p_appears(row.q, covered=row.kind == "view" and row.requires == "covered")


def worth_asking(
    errand: Errand, believed: BeliefReply, cover: State, out: frozenset[str]
) -> tuple[tuple[int, ...], tuple[str, ...]]:
    """Tracks and information actions of which the robot must say whether it can.

    `out` are information actions that are used up or given up.
    """
    belief = JointBelief.read(believed.belief)
    grasps = actions.candidates(belief, errand.target.relation, cover)
    informs = actions.expandable(errand.rows, cover, out)
    return tuple(c.track for c in grasps), tuple(row.name for row in informs)


def choice_of(chosen: QValue | None) -> Choice | None:
    """The action that a Q value is of."""
    if chosen is None:
        return None
    if chosen.track is not None and chosen.relation is not None:
        return Grasp(track=chosen.track, relation=cast(Relation, chosen.relation))
    return Defer() if chosen.action == "defer" else Inform(name=chosen.action)


def _without_defer(solution: Solution) -> Solution:
    q_values = tuple(q for q in solution.q_values if q.action != "defer")
    lowest = min((q.value for q in q_values), default=solution.value)
    chosen = next((q for q in q_values if q.value <= lowest + TIE), None)
    return replace(solution, q_values=q_values, chosen=chosen, value=lowest)
