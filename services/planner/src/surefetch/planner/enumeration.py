"""Every decision node, level by level: the plain way to look ahead, for beliefs that do not factor.

Nodes of one level are rows of arrays, so that numpy does the counting; nothing is merged. The full
method has a faster way (`tensors`); this one also serves the factorized belief, in which the order
of observations matters, and is what the faster one is checked against.

Letters in shapes: b nodes, N tracks, R relations, Y symbols, L tracks that a look may show one of,
E = L·Y outcomes.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import InformRow
from surefetch.common.joint_belief import factorized
from surefetch.planner import actions
from surefetch.planner.actions import State
from surefetch.planner.futures import Array, Outcomes, outcomes
from surefetch.planner.problem import Problem

CELLS: Final = 1 << 21
"""Numbers in the arrays of the nodes that are expanded at once."""


@dataclass(frozen=True, eq=False)
class Nodes:
    """Normalised beliefs, one a row."""

    p_tracked: Array
    """(b, N, R)"""
    p_unobs: Array
    """(b,)"""
    p_abs: Array
    """(b,)"""

    def __len__(self) -> int:
        return len(self.p_abs)

    def chunks(self, size: int) -> Iterator["Nodes"]:
        """The same nodes in order, at most `size` at a time."""
        for start in range(0, len(self), size):
            part = slice(start, start + size)
            yield Nodes(self.p_tracked[part], self.p_unobs[part], self.p_abs[part])


class Enumeration:
    """Q of information actions at the root of one problem with at least one track."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._foreseen = np.array(problem.foreseen)
        self._outcomes: dict[str, Outcomes] = {}

    def q(self, row: InformRow) -> float:
        """The value of one admissible information action at the root."""
        problem, belief = self._problem, self._problem.belief
        root = Nodes(belief.p_tracked[None], np.array([belief.p_unobs]), np.array([belief.p_abs]))
        return float(self._looking(root, row, problem.state, problem.used, problem.horizon)[0])

    def _looking(
        self, nodes: Nodes, row: InformRow, state: State, used: frozenset[str], depth: int
    ) -> Array:
        """(b,) of taking one information action at every node. Source: eq:bellman-recursion."""
        size = max(1, CELLS // max(1, self._outcomes_of(row).ratio[:, :, 0].size * self._n_masses))
        parts = [
            self._looking_at_once(part, row, state, used | {row.name}, depth - 1)
            for part in nodes.chunks(size)
        ]
        return np.concatenate(parts)

    def _looking_at_once(
        self, nodes: Nodes, row: InformRow, state: State, used: frozenset[str], depth: int
    ) -> Array:
        value = np.full(len(nodes), row.cost)
        for after, p in actions.transitions(row, state, self._problem.p_remove):
            appearing = self._problem.appears(row, after)
            following, chance = self._after(nodes, row, appearing)
            values = self._values(following, after, used, depth).reshape(chance.shape)
            value += p * (chance * values).sum(axis=1)
            value += p * appearing * nodes.p_unobs * self._problem.found_cost
        return value

    def _after(self, nodes: Nodes, row: InformRow, appearing: float) -> tuple[Nodes, Array]:
        """The nodes after each outcome, node by node, and the chances (b, E) of the outcomes.

        With the chance `appearing` a target without a track gets one; those are other outcomes.
        """
        p_unobs = nodes.p_unobs * (1.0 - appearing)
        ratio, weight = self._outcomes_of(row).ratio, self._outcomes_of(row).weight
        n_foreseen, n_symbols, n_relations = ratio.shape
        p = np.repeat(nodes.p_tracked[:, None], n_foreseen * n_symbols, axis=1)
        p = p.reshape(len(nodes), n_foreseen, n_symbols, -1, n_relations)
        p[:, np.arange(n_foreseen), :, self._foreseen, :] *= ratio[:, None]
        tracked = p.sum(axis=(3, 4))
        total = tracked + (p_unobs + nodes.p_abs)[:, None, None]
        p /= total[..., None, None]
        if self._problem.options.factorized:
            p = factorized(p)
        chance = (total * weight).reshape(len(nodes), -1)
        following = Nodes(
            p.reshape(chance.size, -1, n_relations),
            (p_unobs[:, None, None] / total).reshape(-1),
            (nodes.p_abs[:, None, None] / total).reshape(-1),
        )
        return following, chance

    def _values(self, nodes: Nodes, state: State, used: frozenset[str], depth: int) -> Array:
        """(b,) of the cheapest admissible action at every node."""
        rows = self._problem.rows
        informs = actions.expandable(rows, state, used) if depth > 0 else ()
        value = np.minimum(self._grasping(nodes, state), self._deferring(nodes, informs))
        for row in informs:
            value = np.minimum(value, self._looking(nodes, row, state, used, depth))
        return np.where(np.isinf(value), self._problem.costs.stalled, value)

    def _grasping(self, nodes: Nodes, state: State) -> Array:
        """(b,) of the best grasp that is open, +inf where none is."""
        problem = self._problem
        heaviest = np.argsort(-nodes.p_tracked.sum(axis=2), axis=1, kind="stable")
        considered = heaviest[:, : actions.N_CANDIDATES, None]
        p = np.take_along_axis(nodes.p_tracked, considered, axis=1)  # (b, 3, R)
        likelier = p.argmax(axis=2)
        p_grasp = p.max(axis=2)
        open_ = np.array(actions.graspable(problem.asked, state))[likelier]
        if not problem.options.no_conformal:
            compatible = np.array(actions.compatible_with(problem.asked))
            alone = (self._in_set(nodes.p_tracked) & compatible).sum(axis=(1, 2)) == 1
            open_ &= self._in_set(p_grasp) & alone[:, None] & (p_grasp >= problem.commit_at_least)
        cost = actions.grasp_cost(p_grasp, problem.p_held, problem.costs)
        best: Array = np.where(open_, cost, np.inf).min(axis=1)
        return best

    def _deferring(self, nodes: Nodes, informs: tuple[InformRow, ...]) -> Array:
        """(b,) of abstaining, +inf where it is not admissible."""
        if self._problem.options.no_defer:
            return np.full(len(nodes), np.inf)
        cost = actions.defer_cost(nodes.p_abs, self._problem.costs)
        if not informs:
            return cost
        others = self._in_set(nodes.p_tracked).any(axis=(1, 2)) | self._in_set(nodes.p_unobs)
        only_absent = self._in_set(nodes.p_abs) & ~others
        only_absent &= nodes.p_abs >= self._problem.defer_at_least
        return np.where(only_absent, cost, np.inf)

    def _in_set(self, p: Array) -> NDArray[np.bool_]:
        """Which of these probabilities the conformal set holds. Source: eq:conformal-set."""
        held: NDArray[np.bool_] = 1.0 - p <= self._problem.q_hat
        return held

    def _outcomes_of(self, row: InformRow) -> Outcomes:
        if row.name not in self._outcomes:
            y0 = [self._problem.y0[n] for n in self._foreseen]
            self._outcomes[row.name] = outcomes(self._problem.future, row, y0)
        return self._outcomes[row.name]

    @cached_property
    def _n_masses(self) -> int:
        return int(self._problem.belief.p_tracked.size)
