"""What a decision problem costs without the rules that hang on the belief: as it is exported. Pure.

Every grasp that instruction and cover allow is open, and so is abstaining. Beliefs are worked
through one look after another, nothing merged, with all nodes of a level as rows of an array.

Letters in shapes: b nodes, Z hypotheses (tracks by relation, unobs, abs), S shown (track, symbol).
"""

from typing import Final

import numpy as np

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import OBSERVATIONS, RELATIONS
from surefetch.planner import actions
from surefetch.planner.actions import State
from surefetch.planner.futures import Array
from surefetch.planner.problem import Problem

CELLS: Final = 1 << 21
"""Numbers in the arrays of the nodes that are expanded at once."""


def refuse_what_cannot_be_said(problem: Problem) -> None:
    """Raise ValueError for switches that make the search something else than a decision problem."""
    options = problem.options
    switches = ("factorized", "hypothesis_independent_future", "no_defer")
    if on := [name for name in switches if getattr(options, name)]:
        raise ValueError(f"a POMDP cannot say {', '.join(on)}; export the problem without")
    if any(problem.p_appears.values()):
        raise ValueError("targets that appear without a track cannot be exported")
    if len(problem.foreseen) < len(problem.y0):
        raise ValueError("looks that show one of some tracks only cannot be exported")


def masses_of(problem: Problem) -> Array:
    """The belief at the root as (Z,), normalised."""
    belief = problem.belief
    masses = np.array([*belief.p_tracked.ravel(), belief.p_unobs, belief.p_abs])
    normal: Array = masses / masses.sum()
    return normal


def likelihoods(problem: Problem, row: InformRow) -> Array:
    """(Z, S): chance of every (track, symbol) after a look; tracks are as likely as one another.

    Source: paper, eq:future-outcome.
    """
    y0 = problem.y0
    shown = np.empty((len(RELATIONS) * len(y0) + 2, len(y0), len(OBSERVATIONS)))
    for i, y in enumerate(y0):
        E = problem.future.likelihood(row, y)  # (classes, observations), distractor last
        shown[:, i] = E[-1]
        first = i * len(RELATIONS)
        shown[first : first + len(RELATIONS), i] = E[:-1]
    return shown.reshape(len(shown), -1) / max(1, len(y0))


def value(problem: Problem) -> float:
    """The least expected cost of the exported problem; never more than `search.solve` finds.

    Raises:
        ValueError: see `refuse_what_cannot_be_said`.
    """
    refuse_what_cannot_be_said(problem)
    return float(_Unruled(problem).values(masses_of(problem)[None], at_root=True)[0])


class _Unruled:
    """The recursion. Masses stay unnormalised, so that values carry their chances."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._shown = {row.name: likelihoods(problem, row) for row in problem.rows}

    def values(self, masses: Array, *, at_root: bool) -> Array:
        """(b,) of nodes (b, Z) in the state, and after the actions, of the root."""
        problem = self._problem
        return self._values(masses, problem.state, problem.used, problem.horizon, at_root)

    def _values(
        self, masses: Array, state: State, used: frozenset[str], depth: int, at_root: bool = False
    ) -> Array:
        problem = self._problem
        total = masses.sum(axis=1)
        best: Array = total * actions.defer_cost(masses[:, -1] / total, problem.costs)
        if columns := self._graspable(state, at_root):
            p = masses[:, columns].max(axis=1) / total
            cost = actions.grasp_cost(p, problem.p_held, problem.costs)
            best = np.minimum(best, total * cost)
        for row in actions.expandable(problem.rows, state, used) if depth > 0 else ():
            best = np.minimum(best, self._looking(masses, row, state, used, depth))
        return best

    def _graspable(self, state: State, at_root: bool) -> list[int]:
        """Hypotheses, as columns, whose object may be grasped."""
        problem = self._problem
        return [
            n * len(RELATIONS) + r
            for n, track in enumerate(problem.belief.tracks)
            for r, within in enumerate(actions.graspable(problem.asked, state))
            if within and (not at_root or track in problem.feasible)
        ]

    def _looking(
        self, masses: Array, row: InformRow, state: State, used: frozenset[str], depth: int
    ) -> Array:
        """(b,) of one look at every node. Source: paper, eq:bellman-recursion."""
        size = max(1, CELLS // max(1, self._shown[row.name].size))
        parts = np.split(masses, range(size, len(masses), size))
        return np.concatenate(
            [self._looking_at_once(part, row, state, used, depth) for part in parts]
        )

    def _looking_at_once(
        self, masses: Array, row: InformRow, state: State, used: frozenset[str], depth: int
    ) -> Array:
        following = masses[:, None, :]
        if self._problem.y0:
            following = following * self._shown[row.name].T
        n_shown = following.shape[1]
        value: Array = row.cost * masses.sum(axis=1)
        for after, p in actions.transitions(row, state, self._problem.p_remove):
            below = self._values(
                following.reshape(-1, masses.shape[1]), after, used | {row.name}, depth - 1
            )
            value = value + p * below.reshape(-1, n_shown).sum(axis=1)
        return value
