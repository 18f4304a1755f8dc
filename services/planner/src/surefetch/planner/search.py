"""Exact expectimax to a horizon: a problem in, the value of every admissible action out. Pure.

Source: paper, eq:bellman-recursion.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

from surefetch.common.cell import InformRow
from surefetch.common.conformal import conformal_set
from surefetch.common.hypotheses import OBSERVATIONS
from surefetch.common.joint_belief import JointBelief, normalised
from surefetch.common.messages import QValue
from surefetch.planner import actions, enumeration, tensors
from surefetch.planner.actions import Candidate, State
from surefetch.planner.problem import Problem, Solution

TIE: Final = 1e-12
"""Values this close are equal, and the first in tie order is taken."""

Lookahead = Callable[[InformRow], float]
"""Q of an information action at the root."""


def solve(problem: Problem) -> Solution:
    """The Q value of every admissible root action, and the first of the lowest."""
    gamma = conformal_set(problem.belief.named(), problem.q_hat)
    informs = _informs(problem, problem.state, problem.used, problem.horizon)
    terminal = _terminal(problem, gamma, problem.state, informs, at_root=True)
    lookahead = _lookahead(problem) if informs else None
    looking = [QValue(action=row.name, value=lookahead(row)) for row in informs if lookahead]
    q_values = (*terminal, *looking)
    lowest = min((q.value for q in q_values), default=problem.costs.stalled)
    chosen = next((q for q in q_values if q.value <= lowest + TIE), None)
    return Solution(gamma, q_values, chosen, lowest, count_nodes(problem))


def count_nodes(problem: Problem) -> int:
    """Decision nodes of the full enumeration, the root included."""
    branches = max(1, len(problem.foreseen) * len(OBSERVATIONS))

    def below(state: State, used: frozenset[str], depth: int) -> int:
        return 1 + sum(
            branches * below(after, used | {row.name}, depth - 1)
            for row in _informs(problem, state, used, depth)
            for after, _ in actions.transitions(row, state, problem.p_remove)
        )

    return below(problem.state, problem.used, problem.horizon)


def _lookahead(problem: Problem) -> Lookahead:
    """The cheapest exact way to look ahead in this problem."""
    if problem.options.hypothesis_independent_future:
        constant = replace(problem, p_appears={})
        return lambda row: _value_of_looking(constant, row)
    if not problem.belief.tracks:
        return lambda row: _value_of_looking(problem, row)
    if problem.options.factorized:
        return enumeration.Enumeration(problem).q
    return tensors.Lookahead(problem).q


def _informs(
    problem: Problem, state: State, used: frozenset[str], depth: int
) -> tuple[InformRow, ...]:
    return actions.expandable(problem.rows, state, used) if depth > 0 else ()


def _terminal(
    problem: Problem,
    gamma: tuple[str, ...],
    state: State,
    informs: tuple[InformRow, ...],
    *,
    at_root: bool,
) -> list[QValue]:
    """Admissible grasps by rank, then defer, for the root belief in some state."""
    costs, options = problem.costs, problem.options

    def may_grasp(candidate: Candidate) -> bool:
        reachable = not at_root or candidate.track in problem.feasible
        sure = options.no_conformal or actions.semantically_eligible(
            candidate, gamma, problem.asked, problem.commit_at_least
        )
        return reachable and sure

    q_values = [
        QValue(
            action="grasp",
            value=actions.grasp_cost(candidate.p, problem.p_held, costs),
            track=candidate.track,
            relation=candidate.relation,
        )
        for candidate in actions.candidates(problem.belief, problem.asked, state)
        if may_grasp(candidate)
    ]
    p_abs = problem.belief.p_abs
    may_defer = actions.may_defer(gamma, informs, p_abs, problem.defer_at_least)
    if may_defer and not options.no_defer:
        q_values.append(QValue(action="defer", value=actions.defer_cost(p_abs, costs)))
    return q_values


def _value_of_looking(problem: Problem, row: InformRow) -> float:
    """Q of an information action where no look says anything of the tracks."""
    value = row.cost
    for after, p in actions.transitions(row, problem.state, problem.p_remove):
        p_found = problem.belief.p_unobs * problem.appears(row, after)
        following = replace(
            problem,
            state=after,
            used=problem.used | {row.name},
            horizon=problem.horizon - 1,
            belief=_without(problem.belief, p_found),
        )
        value += p * (p_found * problem.found_cost + (1.0 - p_found) * _value(following))
    return value


def _value(problem: Problem) -> float:
    gamma = conformal_set(problem.belief.named(), problem.q_hat)
    informs = _informs(problem, problem.state, problem.used, problem.horizon)
    ends = _terminal(problem, gamma, problem.state, informs, at_root=False)
    looks = [_value_of_looking(problem, row) for row in informs]
    return min([*(q.value for q in ends), *looks], default=problem.costs.stalled)


def _without(belief: JointBelief, p_found: float) -> JointBelief:
    """The belief where the target has not appeared, though it had this chance to."""
    if p_found == 0.0:
        return belief
    return normalised(replace(belief, p_unobs=belief.p_unobs - p_found))
