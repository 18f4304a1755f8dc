"""POUCT by pomdp_py (the extra `baselines`) on one decision problem.

What is legal is read off the history, never off the sampled state, which would tell the tree what
is hidden. After as many looks as the horizon has it is legal only to end, so that looking for ever
earns nothing. The library draws with Python's own generator, which is seeded from the policy's
stream before every plan and put back after it.

Source: Silver and Veness, Monte-Carlo Planning in Large POMDPs (2010).
"""

import random
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final

import numpy as np
import pomdp_py

from surefetch.common.hypotheses import RELATIONS
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.evaluation.policies.pouct_model import (
    END,
    N_RELATIONS,
    REST,
    Act,
    History,
    Hypothetical,
    Outcomes,
)
from surefetch.planner import actions
from surefetch.planner.actions import State
from surefetch.planner.problem import Problem

DISCOUNT: Final = 1.0
NO_TIME_LIMIT: Final = -1.0


class Legal(pomdp_py.RolloutPolicy):  # type: ignore[misc]
    """What is legal after a history, and how a rollout goes on from there: by chance."""

    def __init__(self, problem: Problem, at_root: Sequence[Choice], model: Outcomes) -> None:
        self._problem = problem
        self._model = model
        self._looks = {row.name: Act(Inform(name=row.name), row) for row in problem.rows}
        self._grasps = dict(_grasps(problem))
        self._defer = Act(Defer(), costs=_defer_costs(problem))
        self._known: dict[tuple[str | State, ...], list[Act]] = {
            (problem.state,): [self._act(choice) for choice in at_root]
        }

    def get_all_actions(self, state: object = None, history: History = ()) -> list[Act]:
        """Legal actions; a list, since the library draws from it."""
        del state  # Hidden.
        if history and history[-1][1] is END:
            return [REST]
        cover = history[-1][1].cover if history else self._problem.state
        key = (cover, *(action.row.name for action, _ in history if action.row is not None))
        if key not in self._known:
            self._known[key] = self._legal(cover, frozenset(key[1:]))
        return self._known[key]

    def rollout(self, state: Hypothetical, history: History = ()) -> Act:
        """Any legal action, each as likely as the others."""
        return random.choice(self.get_all_actions(state, history))

    def _legal(self, cover: State, taken: frozenset[str]) -> list[Act]:
        problem = self._problem
        within = actions.graspable(problem.asked, cover)
        grasps = [act for column, act in self._grasps.items() if within[column % N_RELATIONS]]
        rows = actions.expandable(problem.rows, cover, problem.used | taken)
        looks = [self._looks[row.name] for row in rows] if len(taken) < problem.horizon else []
        return [*grasps, self._defer, *looks]

    def _act(self, choice: Choice) -> Act:
        match choice:
            case Inform(name=name):
                return self._looks[name]
            case Grasp(track=track, relation=relation):
                i = self._problem.belief.tracks.index(track)
                return self._grasps[i * N_RELATIONS + RELATIONS.index(relation)]
            case _:
                return self._defer


class SureOrNot(Legal):
    """Rollouts that end at once: by the most probable grasp, or by deferring if that costs less."""

    def rollout(self, state: Hypothetical, history: History = ()) -> Act:
        """The end of the lowest cost under what the history lets one believe."""
        legal = self.get_all_actions(state, history)
        if legal == [REST]:
            return REST
        masses = self._model.believed(history)
        total = sum(masses)
        costs, problem = self._problem.costs, self._problem
        best = self._defer, actions.defer_cost(masses[-1] / total, costs)
        for column, act in self._grasps.items():
            cost = actions.grasp_cost(masses[column] / total, problem.p_held, costs)
            if cost < best[1] and act in legal:
                best = act, cost
        return best[0]


def plan(
    problem: Problem,
    at_root: Sequence[Choice],
    *,
    strong: bool,
    exploration: float,
    simulations: int,
    rng: np.random.Generator,
) -> tuple[Choice, float]:
    """The action that POUCT finds best, and what it finds it to cost.

    Args:
        problem: conformal threshold and options of the search have no effect.
        at_root: what may be done now; at least one action.
        strong: looks show all tracks, and rollouts end by what is believed; otherwise a look shows
            one track, drawn, and rollouts go on by chance.
        exploration: constant of the upper confidence bound; returns range over about one.
        simulations: of every plan.
        rng: the policy's own.
    """
    model = Outcomes(problem, all_tracks=strong)
    legal = (SureOrNot if strong else Legal)(problem, at_root, model)
    agent = pomdp_py.Agent(model.start, legal, blackbox_model=model)
    planner = pomdp_py.POUCT(
        max_depth=problem.horizon + 1,
        discount_factor=DISCOUNT,
        planning_time=NO_TIME_LIMIT,
        num_sims=simulations,
        exploration_const=exploration,
        num_visits_init=0,
        rollout_policy=legal,
    )
    with _seeded(rng):
        best = planner.plan(agent)
    return best.choice, -float(agent.tree[best].value)


def _grasps(problem: Problem) -> Iterable[tuple[int, Act]]:
    """By column of the hypothesis under which they are right; those that the instruction allows."""
    suits = actions.compatible_with(problem.asked)
    n_hypotheses = problem.belief.p_tracked.size + 2
    for n, track in enumerate(problem.belief.tracks):
        for r, relation in enumerate(RELATIONS):
            if suits[r]:
                column = n * N_RELATIONS + r
                right = (float(z == column) for z in range(n_hypotheses))
                costs = [actions.grasp_cost(p, problem.p_held, problem.costs) for p in right]
                yield column, Act(Grasp(track=track, relation=relation), costs=costs)


def _defer_costs(problem: Problem) -> list[float]:
    n_present = problem.belief.p_tracked.size + 1
    return [*([problem.costs.defer] * n_present), 0.0]


@contextmanager
def _seeded(rng: np.random.Generator) -> Iterator[None]:
    """Python's generator, seeded from another; as it was before, after."""
    before = random.getstate()
    random.seed(int(rng.integers(2**63)))
    try:
        yield
    finally:
        random.setstate(before)
