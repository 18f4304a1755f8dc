"""What TAMPURA learns by simulation keeps to the laws of belief, and it decides by it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_observation import Known, observation

from surefetch.common.cases import read_cases
from surefetch.common.hypotheses import RELATIONS
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.tampura import Tampura
from surefetch.evaluation.policies.tampura_beliefs import (
    BINS,
    Abstract,
    Concrete,
    Looks,
    abstracted,
    imagined,
)
from surefetch.evaluation.policies.tampura_learning import SAMPLES, Learned, upper
from surefetch.planner import actions
from surefetch.planner.cases import KINDS, PlanCase
from surefetch.planner.pomdpx_value import value
from surefetch.planner.problem import Problem

GOLDEN = Path(__file__).parents[2] / "golden" / "cases" / "plan.json"
CASES = {
    case.name: case.problem()
    for case in read_cases(GOLDEN, KINDS, command="test")
    if isinstance(case, PlanCase)
}
WITH_TRACKS = sorted(name for name, one in CASES.items() if one.belief.tracks)


def everything(problem: Problem) -> list[Choice]:
    within = actions.graspable(problem.asked, problem.state)
    grasps = [
        Grasp(track=track, relation=relation)
        for track in problem.belief.tracks
        if track in problem.feasible
        for relation, suits in zip(RELATIONS, within, strict=True)
        if suits
    ]
    rows = actions.expandable(problem.rows, problem.state, problem.used)
    looks = [Inform(name=row.name) for row in rows] if problem.horizon > 0 else []
    return [*grasps, Defer(), *looks]


def learned(problem: Problem, seed: int = 0, confirmed_at: float = 0.9) -> Learned:
    made = Learned(problem, everything(problem), confirmed_at, 1.0, problem.horizon)
    made.learn(np.random.default_rng(seed))
    return made


@pytest.mark.parametrize("name", ["full_3_open_26", "full_2_covered_24", "full_1_covered_21"])
@pytest.mark.parametrize("p_appears", [0.0, 0.6])
def test_on_average_a_look_changes_no_belief(name: str, p_appears: float) -> None:
    """A target that appears had been unobserved."""
    problem = CASES[name]
    problem = replace(problem, p_appears={row.name: p_appears for row in problem.rows})
    looks, rng = Looks(problem), np.random.default_rng(3)
    row = actions.expandable(problem.rows, problem.state, problem.used)[0]
    mean, n = np.zeros_like(looks.root.masses), 6000
    for _ in range(n):
        after = looks.sample(looks.root, row, rng)
        if after is None:
            mean[-2] += 1.0 / n
        else:
            assert after.masses.sum() == pytest.approx(1.0)
            mean += after.masses / n
    assert mean == pytest.approx(looks.root.masses, abs=4.0 * 0.5 / np.sqrt(n))


@given(
    st.lists(st.floats(0.0, 1.0), min_size=6, max_size=6),
    st.sampled_from(WITH_TRACKS),
    st.floats(0.3, 0.99),
    st.floats(0.3, 0.99),
)
@settings(deadline=None)
def test_a_higher_threshold_confirms_no_more_tracks(
    p: list[float], name: str, a: float, b: float
) -> None:
    problem = CASES[name]
    masses = np.resize(np.array(p) + 1e-6, problem.belief.p_tracked.size + 2)
    at = Concrete(masses / masses.sum(), "open", frozenset())
    low, high = (confirmed(abstracted(at, problem, t)) for t in sorted((a, b)))
    assert high <= low


def confirmed(at: Abstract) -> set[int]:
    return {i for i, standing in at.standings if standing == "confirmed"}


@pytest.mark.parametrize("name", WITH_TRACKS)
def test_what_is_imagined_is_settled(name: str) -> None:
    problem = CASES[name]
    at = abstracted(Looks(problem).root, problem, 0.9)
    for row in actions.expandable(problem.rows, problem.state, problem.used):
        outcomes = list(imagined(at, row))
        for outcome in outcomes:
            assert [i for i, _ in outcome.standings] == [i for i, _ in at.standings]
            assert not any(standing == "open" for _, standing in outcome.standings)
            assert outcome.used == at.used | {row.name} and outcome.unobs == 0
            assert outcome.cover == ("open" if row.kind == "remove_cover" else at.cover)
        absent = [outcome for outcome in outcomes if outcome.absent == len(BINS)]
        assert len(absent) == 1 and not confirmed(absent[0])


@given(st.integers(0, 60), st.integers(0, 60))
def test_optimism_lies_above_the_rate_and_fades_with_trials(n_came: int, n_missed: int) -> None:
    n = n_came + n_missed
    assert (n_came + 1) / (n + 2) < upper(n_came, n) < 1.0
    assert upper(n_came, n + 1) < upper(n_came, n) < upper(n_came + 1, n + 1)


@pytest.mark.parametrize("name", ["full_3_open_26", "full_2_covered_24", "full_1_covered_21"])
def test_every_sample_is_of_a_look_that_is_open_where_it_is_taken(name: str) -> None:
    made = learned(CASES[name])
    assert sum(came.total() for came in made._counts.values()) == SAMPLES
    for at, look in made._counts:
        assert look in {row.name for row in made._open(at)}
        assert at in made._beliefs


@pytest.mark.parametrize("name", WITH_TRACKS)
def test_looking_ahead_never_costs_more_than_ending_now(name: str) -> None:
    problem = CASES[name]
    made = learned(problem)
    ends = [end.cost + end.risk for end in made._ends(made.root)]
    choice, cost = made.best()
    assert choice in everything(problem) and cost <= min(ends)


@pytest.mark.parametrize(
    "name", ["tiny_look", "covered_inside", "covered_outside", "full_1_open_20", "absent_alone"]
)
def test_it_costs_about_what_the_exact_solution_costs(name: str) -> None:
    """A hundred samples and a coarse belief: the mean of some streams comes near."""
    costs = [learned(CASES[name], seed).best()[1] for seed in range(8)]
    assert np.mean(costs) == pytest.approx(value(CASES[name]), abs=0.03)


def test_a_target_that_may_appear_is_worth_a_look() -> None:
    hidden = CASES["tiny_no_track_covered"]
    assert learned(hidden).best()[0] == Defer()
    unseen = replace(hidden.belief, p_unobs=0.9, p_abs=0.1)
    hidden = replace(hidden, belief=unseen, p_appears={"remove_cover": 0.95})
    assert learned(hidden).best()[0] == Inform(name="remove_cover")


def acted(now: Observation, seed: int = 0, discount: float = 1.0) -> tuple[Choice | None, str]:
    policy = Tampura(discount=discount)
    return policy.act(replace(now, rng=np.random.default_rng(seed))), policy.because


def test_it_grasps_when_sure_defers_when_nothing_is_there_and_looks_in_between() -> None:
    rivals = [Known("MU", 0.4), Known("MU", 0.4, at_m=(0.9, -0.2))]
    assert acted(observation([Known("MO", 0.999)]))[0] == Grasp(track=1, relation="outside")
    assert acted(observation([Known("mismatch", 0.001)]))[0] == Defer()
    assert isinstance(acted(observation(rivals, unobs=0.1))[0], Inform)


def test_equal_streams_learn_the_same_and_others_something_else() -> None:
    now = observation([Known("MU", 0.4), Known("UU", 0.3, at_m=(0.9, -0.2))], unobs=0.2)
    assert acted(now) == acted(now)
    assert acted(now)[1] != acted(now, seed=1)[1]
    assert acted(now, discount=0.95)[1] != acted(now)[1]
