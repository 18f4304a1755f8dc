"""The values of all nodes at once, as arrays over what was observed on the way. Pure.

Observations of different actions commute in the belief, so a node is a *set* of actions with one
outcome each, and the values of one set form an `OutcomeGrid`. Beliefs are unnormalised
(`futures.Outcomes`), so looking ahead is a weighted sum over the axes of one action. What
abstaining costs is linear in the belief and sums in closed form; only what a grasp saves against it
is summed outcome by outcome.

A target without a track may get one by a look. What follows then has one cost, so that only the
mass of those that stay unseen goes on; it is the same at all nodes of a set.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from surefetch.common.cell import InformRow
from surefetch.planner import actions
from surefetch.planner.actions import State
from surefetch.planner.futures import Array, outcomes
from surefetch.planner.observed import Observed
from surefetch.planner.outcome_grid import OutcomeGrid
from surefetch.planner.problem import Problem
from surefetch.planner.rivals import NONE, Stakes

Taken = tuple[str, ...]
"""Actions on the way to a node, in the order of the axes."""

CELLS: Final = 1 << 21
"""Outcomes worked out at once: enough to keep numpy busy, few enough for the cache."""


class Lookahead:
    """Q of information actions at the root of one problem with at least one track."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        belief = problem.belief
        self._masses = belief.p_tracked
        self._rows = {row.name: row for row in problem.rows}
        # Where a removal comes before every view, its axis is first and is never summed over.
        self._order = sorted(problem.rows, key=lambda row: row.kind == "view")
        foreseen = problem.foreseen
        y0 = [problem.y0[n] for n in foreseen]
        shown = {row.name: outcomes(problem.future, row, y0) for row in self._order}
        self._weights = {name: outcome.weight for name, outcome in shown.items()}
        ratios = {name: outcome.ratio for name, outcome in shown.items()}
        self._observed = Observed(self._masses, np.array(foreseen), ratios)
        self._values: dict[tuple[Taken, State], Array] = {}
        self._savings: dict[tuple[Taken, State], dict[str, Array]] = {}
        self._last: dict[tuple[Taken, State], set[str]] = {}
        for taken, row, state in self._ways((), problem.state):
            for after, _ in actions.transitions(row, state, problem.p_remove):
                self._last.setdefault((self._with(taken, row), after), set()).add(row.name)

    def q(self, row: InformRow) -> float:
        """The value of one admissible information action at the root."""
        return float(self._looking((), row, self._problem.state))

    def _ways(self, taken: Taken, state: State) -> Iterator[tuple[Taken, InformRow, State]]:
        """Every node set that can be reached, with an action from there and the state there."""
        for row in self._informs(taken, state):
            yield taken, row, state
            for after, _ in actions.transitions(row, state, self._problem.p_remove):
                yield from self._ways(self._with(taken, row), after)

    def _looking(self, taken: Taken, row: InformRow, state: State) -> Array:
        """Q of one more action at every node of a set. Source: eq:bellman-recursion."""
        following = self._with(taken, row)
        value = row.cost * self._grid(taken, state).mass()
        for after, p in actions.transitions(row, state, self._problem.p_remove):
            appearing = self._unseen(taken, state) * self._problem.appears(row, after)
            value = value + p * appearing * self._problem.found_cost
            value = value + p * self._expected(following, row.name, after)
        return value

    def _expected(self, taken: Taken, name: str, state: State) -> Array:
        """The values of a set of nodes, summed over what one of its actions may show."""
        if self._informs(taken, state):
            return _summed(self._value(taken, state), taken.index(name), self._weight(name))
        stakes = self._stakes(taken, state)
        others = tuple(other for other in taken if other != name)
        left = OutcomeGrid(self._observed, others, self._left(taken, state), stakes)
        abstaining = stakes.resort * left.mass() - stakes.floor
        return abstaining - self._saved(taken, state)[name]

    def _value(self, taken: Taken, state: State) -> Array:
        """The lowest cost at every node of a set from which looking may go on."""
        if (taken, state) not in self._values:
            grid = self._grid(taken, state)
            absent = self._surely_absent(grid, self._unseen(taken, state))
            value = np.minimum(-grid.gains(missing=NONE), absent)
            for row in self._informs(taken, state):
                value = np.minimum(value, self._looking(taken, row, state))
            self._values[taken, state] = value
        return self._values[taken, state]

    def _saved(self, taken: Taken, state: State) -> dict[str, Array]:
        """What grasping saves at the leaves, summed over what each last action may show."""
        if (taken, state) not in self._savings:
            sums: dict[str, list[Array]] = {name: [] for name in self._last[taken, state]}
            for piece in self._pieces(taken):
                gains = self._grid(taken, state, piece).gains(missing=0.0)
                for name, parts in sums.items():
                    axis = taken.index(name)
                    weight = self._weight(name)[piece] if axis == 0 else self._weight(name)
                    parts.append(_summed(gains, axis, weight))
            self._savings[taken, state] = {
                name: sum(parts[1:], parts[0]) if name == taken[0] else np.concatenate(parts)
                for name, parts in sums.items()
            }
        return self._savings[taken, state]

    def _pieces(self, taken: Taken) -> Iterator[slice]:
        """Ranges of tracks for the first action, so that one range has about CELLS outcomes."""
        n_foreseen, n_symbols = self._weight(taken[0]).shape
        size = max(1, CELLS // (n_symbols * (n_foreseen * n_symbols) ** (len(taken) - 1)))
        for start in range(0, n_foreseen, size):
            yield slice(start, start + size)

    def _surely_absent(self, grid: OutcomeGrid, p_unobs: float) -> Array:
        """Cost of abstaining where the conformal set is {abs}, which is when it is admissible."""
        problem, belief = self._problem, self._problem.belief
        mass = grid.mass()
        if problem.options.no_defer:
            return np.full_like(mass, np.inf)
        others = np.maximum(grid.heaviest(), p_unobs)
        alone = (1.0 - belief.p_abs / mass <= problem.q_hat) & (1.0 - others / mass > problem.q_hat)
        sure, costs = alone & (belief.p_abs / mass >= problem.defer_at_least), problem.costs
        return np.where(sure, costs.defer * (mass - belief.p_abs), np.inf)

    def _stakes(self, taken: Taken, state: State) -> Stakes:
        """The rule of ending at a set of nodes, and the resort against which grasping stands."""
        problem, costs = self._problem, self._problem.costs
        inner = bool(self._informs(taken, state))
        may_defer = not inner and not problem.options.no_defer
        resort = 0.0 if inner else (costs.defer if may_defer else costs.stalled)
        return Stakes(
            share=1.0 - problem.q_hat,
            conformal=not problem.options.no_conformal,
            least=problem.commit_at_least,
            compatible=actions.compatible_with(problem.asked),
            graspable=actions.graspable(problem.asked, state),
            kappa=1.0 - costs.failed_grasp * (1.0 - problem.p_held),
            eta=1.0 + costs.grasp - resort,
            resort=resort,
            floor=costs.defer * problem.belief.p_abs if may_defer else 0.0,
            optional=may_defer,
        )

    def _grid(self, taken: Taken, state: State, first: slice = slice(None)) -> OutcomeGrid:
        left, stakes = self._left(taken, state), self._stakes(taken, state)
        return OutcomeGrid(self._observed, taken, left, stakes, first)

    def _unseen(self, taken: Taken, state: State) -> float:
        """Mass of a target that has not appeared by any of these actions."""
        mass = self._problem.belief.p_unobs
        for name in taken:
            mass *= 1.0 - self._problem.appears(self._rows[name], state)
        return mass

    def _left(self, taken: Taken, state: State) -> float:
        """Mass before any outcome, where the target has not appeared by these actions."""
        unseen = self._unseen(taken, state)
        return float(self._masses.sum() + unseen + self._problem.belief.p_abs)

    def _informs(self, taken: Taken, state: State) -> tuple[InformRow, ...]:
        if len(taken) >= self._problem.horizon:
            return ()
        return actions.expandable(self._problem.rows, state, self._problem.used | set(taken))

    def _with(self, taken: Taken, row: InformRow) -> Taken:
        return tuple(r.name for r in self._order if r.name in taken or r.name == row.name)

    def _weight(self, name: str) -> Array:
        return self._weights[name]


def _summed(values: Array, action: int, weight: Array) -> Array:
    """Values (two axes per action) times weights (N, Y), summed over one action's axes."""
    n_before = int(np.prod(values.shape[: 2 * action]))
    flat = values.reshape(n_before, weight.size, -1)
    summed: Array = np.matmul(weight.reshape(1, 1, -1), flat)
    return summed.reshape(values.shape[: 2 * action] + values.shape[2 * action + 2 :])
