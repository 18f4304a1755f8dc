"""POUCT finds what the problem is worth, and neither sees what is hidden nor leaves a trace."""

import random
import sys
from dataclasses import replace
from itertools import product
from pathlib import Path

import msgspec
import numpy as np
import pytest
from made_up_observation import Known, observation

from surefetch.common.cases import read_cases
from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import OBSERVATIONS
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.common.parameters import BirthCounts, Parameters
from surefetch.evaluation.policies import decision
from surefetch.evaluation.policies.decision import foreseen, gated, problem_of, ungated
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.pouct import Pouct
from surefetch.evaluation.policies.pouct_model import END, OVER, REST, Hypothetical, Outcomes
from surefetch.evaluation.policies.pouct_tree import Legal, plan
from surefetch.planner.cases import KINDS, PlanCase
from surefetch.planner.pomdpx_value import masses_of, value
from surefetch.planner.problem import Problem

GOLDEN = Path(__file__).parents[2] / "golden" / "cases" / "plan.json"
CASES = {
    case.name: case
    for case in read_cases(GOLDEN, KINDS, command="test")
    if isinstance(case, PlanCase)
}
RIVALS = [Known("MU", 0.45), Known("UU", {"inside": 0.3}), Known("mismatch", 0.05)]


def planned(
    problem: Problem, *, strong: bool, simulations: int, exploration: float = 1.0
) -> tuple[Choice, float]:
    return plan(
        problem,
        everything(problem),
        strong=strong,
        exploration=exploration,
        simulations=simulations,
        rng=np.random.default_rng(0),
    )


def everything(problem: Problem) -> list[Choice]:
    """What a POMDP without rules on the belief admits at the root."""
    legal = Legal(problem, [], Outcomes(problem, all_tracks=True))
    choices = [act.choice for act in legal._legal(problem.state, frozenset()) if act.choice]
    return [c for c in choices if not isinstance(c, Grasp) or c.track in problem.feasible]


@pytest.mark.parametrize(
    "name",
    ["tiny_look", "covered_inside", "covered_outside", "full_1_open_20", "full_2_covered_25"],
)
@pytest.mark.parametrize("strong", [False, True])
def test_many_simulations_cost_what_the_exact_solution_costs(name: str, strong: bool) -> None:
    """In these cases it makes no difference how many tracks a look shows."""
    problem = CASES[name].problem()
    choice, cost = planned(problem, strong=strong, simulations=40_000)
    assert cost == pytest.approx(value(problem), abs=0.012)
    if name.startswith("covered_inside"):
        assert choice == Inform(name="remove_cover")


def test_more_simulations_come_nearer() -> None:
    problem = CASES["full_1_covered_21"].problem()
    apart = [
        planned(problem, strong=False, simulations=n)[1] - value(problem) for n in (500, 50_000)
    ]
    assert 0.0 < apart[1] < apart[0] / 2.0


def test_strong_foresees_all_tracks_at_once() -> None:
    problem = replace(CASES["full_2_open_22"].problem(), horizon=1)
    _, cost = planned(problem, strong=True, simulations=40_000, exploration=0.3)
    assert cost == pytest.approx(best_of_joint_looks(problem), abs=0.012)
    assert cost < value(problem) - 0.05


def best_of_joint_looks(problem: Problem) -> float:
    """Least cost of one look that shows all tracks, worked out symbol by symbol."""
    masses, costs = masses_of(problem), []
    for row in problem.rows:
        if row.requires != problem.state:
            continue
        E = [problem.future.likelihood(row, y) for y in problem.y0]
        cost = row.cost
        for shown in product(range(len(OBSERVATIONS)), repeat=len(E)):
            joint = masses.copy()
            for i, y in enumerate(shown):
                factor = np.full(len(masses), E[i][-1, y])
                factor[2 * i : 2 * i + 2] = E[i][:-1, y]
                joint *= factor
            total, c = joint.sum(), problem.costs
            grasps = (
                c.grasp * total + total - (1 - c.failed_grasp * (1 - problem.p_held)) * joint[:-2]
            )
            cost += min(grasps.min(), c.defer * (total - joint[-1]))
        costs.append(cost)
    return min(costs)


def test_a_target_that_may_appear_is_worth_a_look() -> None:
    problem = CASES["tiny_no_track_covered"].problem()
    assert planned(problem, strong=True, simulations=2000)[0] == Defer()
    unseen = replace(problem.belief, p_unobs=0.9, p_abs=0.1)
    hidden = replace(problem, belief=unseen, p_appears={"remove_cover": 0.95})
    choice, cost = planned(hidden, strong=True, simulations=20_000)
    kept = 0.9 * 0.95 * hidden.found_cost + 0.9 * 0.05 * 0.8
    assert choice == Inform(name="remove_cover")
    assert cost == pytest.approx(0.16 + 0.8 * kept + 0.2 * 0.72, abs=0.03)


def test_what_is_legal_is_a_list_that_does_not_depend_on_the_sampled_state() -> None:
    problem = CASES["full_2_covered_24"].problem()
    model = Outcomes(problem, all_tracks=True)
    legal = Legal(problem, everything(problem), model)
    states = [Hypothetical(z, cover) for z in range(6) for cover in ("open", "covered")]
    removal = next(act for act in legal.get_all_actions() if act.row is not None)
    _, seen, _, _ = model.sample(model.start.random(), removal)
    for history in ((), ((removal, seen),), ((removal, END),)):
        found = [legal.get_all_actions(state, history) for state in states]
        assert all(isinstance(each, list) and each == found[0] for each in found)
    assert legal.get_all_actions(OVER, ((removal, END),)) == [REST]


def test_looking_for_ever_is_not_legal() -> None:
    problem = replace(CASES["full_2_open_22"].problem(), horizon=1)
    model = Outcomes(problem, all_tracks=False)
    legal = Legal(problem, everything(problem), model)
    look = next(act for act in legal.get_all_actions() if act.row is not None)
    _, seen, _, _ = model.sample(model.start.random(), look)
    after = legal.get_all_actions(None, ((look, seen),))
    assert after and all(act.row is None for act in after)


def observed(seed: int = 0) -> Observation:
    return replace(observation(RIVALS, unobs=0.1), rng=np.random.default_rng(seed))


@pytest.mark.parametrize("strong", [False, True])
def test_equal_streams_give_equal_plans_whatever_pythons_generator_was_at(strong: bool) -> None:
    told = []
    for elsewhere in (1, 2):
        random.seed(elsewhere)
        policy = Pouct(strong=strong, gate=False, simulations=300)
        policy.act(observed())
        told.append(policy.because)
        after = random.random()
        random.seed(elsewhere)
        assert random.random() == after
    assert told[0] == told[1]
    another = Pouct(strong=strong, gate=False, simulations=300)
    another.act(observed(seed=1))
    assert another.because != told[0]


def test_the_gate_is_at_the_root() -> None:
    looked_at_all = replace(observed(), used=frozenset({"right", "close_high"}))
    assert gated(looked_at_all) == [Defer()]
    assert Grasp(track=1, relation="outside") in ungated(looked_at_all)
    assert gated(observed()) == [Inform(name="right"), Inform(name="close_high")]
    sure = observation([Known("MO", 0.97)])
    assert Grasp(track=1, relation="outside") in gated(sure)
    for strong in (False, True):
        policy = Pouct(strong=strong, gate=True, simulations=200)
        assert policy.act(looked_at_all) == Defer()
        assert policy.act(observed()) in gated(observed())


def test_strong_knows_how_often_targets_appear_whatever_its_belief_knows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def having(n_appeared: int) -> Parameters:
        counts = BirthCounts(with_target=(n_appeared, 0), without=(8, 0, 0), still_unseen=8)
        births = {"right": {"open": counts, "covered": counts}}
        return msgspec.structs.replace(observed().parameters, births=births)

    monkeypatch.setattr(decision, "_counted", lambda: having(8))
    without = observation(RIVALS, unobs=0.1, profile="paper")
    assert foreseen(without).p_appears["right"] == pytest.approx(0.5)
    assert set(problem_of(without).p_appears.values()) == {0.0}
    with_its_own = replace(observed(), parameters=having(0))
    assert foreseen(with_its_own).p_appears["right"] == pytest.approx(0.1)


def test_what_failed_too_often_is_not_looked_for_in_the_tree() -> None:
    stuck = replace(observed(), given_up=frozenset({"right", "close_high"}))
    problem = problem_of(stuck)
    assert not any(isinstance(choice, Inform) for choice in everything(problem))


def test_without_the_package_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("pouct_model", "pouct_tree"):
        monkeypatch.delitem(sys.modules, f"surefetch.evaluation.policies.{name}")
    monkeypatch.setitem(sys.modules, "pomdp_py", None)
    with pytest.raises(BadInput, match=r"surefetch-evaluation\[baselines\]"):
        Pouct(strong=True, gate=False).act(observed())
