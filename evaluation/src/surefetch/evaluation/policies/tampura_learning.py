"""TAMPURA's counted decision process over abstract beliefs: proposed, sampled, solved.

Plans are proposed by a search in which every outcome that may come of a look can be chosen, at the
upper bound of its chance. Looks on these plans are then tried out in simulation, those that were
tried least first, and what comes of them is counted. The counted process is solved by value
iteration; a look adds to what is used, so that states come back to none before them.

Grasping and deferring need no trials: a belief says how they may end.

Source: Curtis et al., Partially Observable Task and Motion Planning with Uncertainty and Risk
Awareness (2024); from the publication, not from its code.
"""

import heapq
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count, islice
from typing import Final

import numpy as np
from scipy.special import betaincinv

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import RELATIONS
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.evaluation.policies.tampura_beliefs import (
    BINS,
    N_RELATIONS,
    Abstract,
    Concrete,
    Looks,
    abstracted,
    imagined,
)
from surefetch.planner import actions
from surefetch.planner.futures import Array
from surefetch.planner.problem import Problem

SAMPLES: Final = 100
BATCH: Final = 10
PLANS: Final = 10
"""All as published."""
UPPER: Final = 0.95
"""Quantile of a chance that counts as optimistic."""
MOST_SEARCHED: Final = 2000
"""Nodes of one search for plans."""

Outcome = Abstract | None
"""None: a target without a track appeared."""
Trial = tuple[Abstract, str]
"""A look where it is taken."""


@dataclass(frozen=True)
class End:
    """One way to end, and how it may come out."""

    choice: Choice
    cost: float
    """Of taking it, however it comes out."""
    risk: float
    """Expected cost of what it comes to."""
    p_success: float


class Learned:
    """What is known of the decision process from one moment on."""

    def __init__(
        self,
        problem: Problem,
        at_root: Sequence[Choice],
        confirmed_at: float,
        discount: float,
        most_looks: int | None,
    ) -> None:
        self._problem = problem
        self._confirmed_at = confirmed_at
        self._discount = discount
        self._most_looks = most_looks
        self._looks = Looks(problem)
        self._rows = {row.name: row for row in problem.rows}
        self._at_root = at_root
        self._beliefs: dict[Abstract, list[Concrete]] = {}
        self._counts: dict[Trial, Counter[Outcome]] = {}
        self.root = self._keep(self._looks.root)

    def learn(self, rng: np.random.Generator) -> None:
        """Sample looks that lie on promising plans, as often as published."""
        for _ in range(SAMPLES // BATCH):
            trials = [trial for plan in islice(self._plans(), PLANS) for trial in plan]
            known = [(at, name) for at, name in dict.fromkeys(trials) if at in self._beliefs]
            if not known:
                return
            for _ in range(BATCH):
                self._try(min(known, key=self._n_tried), rng)

    def best(self) -> tuple[Choice | None, float]:
        """The action of the lowest cost in the counted process; None: nothing is open."""
        values: dict[Abstract, float] = {}
        ends = [(end.choice, end.cost + end.risk) for end in self._ends(self.root)]
        tried = [row for row in self._open(self.root) if (self.root, row.name) in self._counts]
        looks = [(Inform(name=row.name), self._q(self.root, row, values)) for row in tried]
        return min([*ends, *looks], key=lambda one: one[1], default=(None, math.inf))

    def _value(self, at: Outcome, values: dict[Abstract, float]) -> float:
        if at is None:
            return self._problem.found_cost
        if at not in values:
            ends = [end.cost + end.risk for end in self._ends(at)]
            tried = [row for row in self._open(at) if (at, row.name) in self._counts]
            values[at] = min([*ends, *(self._q(at, row, values) for row in tried)])
        return values[at]

    def _q(self, at: Abstract, row: InformRow, values: dict[Abstract, float]) -> float:
        came = self._counts[at, row.name]
        after = sum(n * self._value(outcome, values) for outcome, n in came.items())
        return row.cost + self._discount * after / came.total()

    def _try(self, trial: Trial, rng: np.random.Generator) -> None:
        at, name = trial
        beliefs = self._beliefs[at]
        belief = beliefs[int(rng.integers(len(beliefs)))]
        after = self._looks.sample(belief, self._rows[name], rng)
        outcome = None if after is None else self._keep(after)
        self._counts.setdefault(trial, Counter())[outcome] += 1

    def _n_tried(self, trial: Trial) -> int:
        return self._counts[trial].total() if trial in self._counts else 0

    def _keep(self, belief: Concrete) -> Abstract:
        at = abstracted(belief, self._problem, self._confirmed_at)
        self._beliefs.setdefault(at, []).append(belief)
        return at

    def _plans(self) -> Iterator[list[Trial]]:
        """Looks of plans to a good end, the most promising plan first."""
        order = count()
        waiting: list[tuple[float, int, Outcome, list[Trial], bool]]
        waiting = [(0.0, next(order), self.root, [], False)]
        for _ in range(MOST_SEARCHED):
            if not waiting:
                return
            length, _, at, plan, is_over = heapq.heappop(waiting)
            if is_over or at is None:
                yield plan
                continue
            for end in self._ends(at):
                if end.p_success > 0.0:
                    over = length + end.cost - math.log(end.p_success)
                    heapq.heappush(waiting, (over, next(order), at, plan, True))
            for row in self._open(at):
                for outcome, p in self._outcomes(at, row):
                    farther = length + row.cost - math.log(p)
                    step = [*plan, (at, row.name)]
                    heapq.heappush(waiting, (farther, next(order), outcome, step, False))

    def _outcomes(self, at: Abstract, row: InformRow) -> Iterator[tuple[Outcome, float]]:
        """What came of a look and what may come of it at best, with optimistic chances."""
        came = self._counts.get((at, row.name), Counter())
        possible: dict[Outcome, None] = dict.fromkeys(came)
        possible |= dict.fromkeys(imagined(at, row))
        if at.unobs > 0 and self._problem.appears(
            row, "open" if row.requires == "open" else at.cover
        ):
            possible[None] = None
        for outcome in possible:
            yield outcome, upper(came[outcome], came.total())

    def _open(self, at: Abstract) -> tuple[InformRow, ...]:
        """Looks that may be taken."""
        problem = self._problem
        if at == self.root:
            names = [choice.name for choice in self._at_root if isinstance(choice, Inform)]
            return tuple(self._rows[name] for name in names)
        n_taken = len(at.used) - len(problem.used)
        if self._most_looks is not None and n_taken >= self._most_looks:
            return ()
        return actions.expandable(problem.rows, at.cover, at.used)

    def _ends(self, at: Abstract) -> list[End]:
        """Grasps of tracks that are not refuted, and deferring."""
        masses = self._masses(at)
        ends = [self._grasp(column, masses) for column in self._graspable(at)]
        costs, p_abs = self._problem.costs, float(masses[-1])
        ends.append(End(Defer(), 0.0, actions.defer_cost(p_abs, costs), p_abs))
        if at == self.root:
            return [end for end in ends if end.choice in self._at_root]
        return ends

    def _graspable(self, at: Abstract) -> Iterator[int]:
        """Columns of hypotheses."""
        within = actions.graspable(self._problem.asked, at.cover)
        for i, standing in at.standings:
            if standing != "refuted":
                yield from (i * N_RELATIONS + r for r in range(N_RELATIONS) if within[r])

    def _grasp(self, column: int, masses: Array) -> End:
        problem, p = self._problem, float(masses[column])
        i, r = divmod(column, N_RELATIONS)
        choice = Grasp(track=problem.belief.tracks[i], relation=RELATIONS[r])
        cost = problem.costs.grasp
        risk = actions.grasp_cost(p, problem.p_held, problem.costs) - cost
        return End(choice, cost, risk, p * problem.p_held)

    def _masses(self, at: Abstract) -> Array:
        """(Z,) the mean of the beliefs that were met there; of an imagined one, what it says."""
        if at in self._beliefs:
            mean: Array = np.mean([belief.masses for belief in self._beliefs[at]], axis=0)
            return mean
        masses = np.zeros(self._problem.belief.p_tracked.size + 2)
        for i, standing in at.standings:
            if standing == "confirmed":
                masses[i * N_RELATIONS : (i + 1) * N_RELATIONS] = 1.0
        masses[-1] = float(at.absent == len(BINS))
        return masses


@cache
def upper(n_came: int, n_tried: int) -> float:
    """The optimistic chance of an outcome that came so often: a quantile of Beta with one added."""
    return float(betaincinv(n_came + 1.0, n_tried - n_came + 1.0, UPPER))
