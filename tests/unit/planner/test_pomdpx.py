"""An exported problem, read back by a reader of its own, is worth what the search says."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from read_pomdpx import read

from surefetch.common.cases import read_cases
from surefetch.common.cell import simulated_cell
from surefetch.common.emission import Emission
from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import CLASSES, OBSERVATIONS
from surefetch.common.joint_belief import JointBelief
from surefetch.planner import cases, pomdpx
from surefetch.planner.actions import Costs, State
from surefetch.planner.cases import KINDS, PlanCase
from surefetch.planner.futures import FutureModel
from surefetch.planner.pomdpx_value import value
from surefetch.planner.problem import Options, Problem
from surefetch.planner.profiles import EXTENDED
from surefetch.planner.search import solve

GOLDEN = Path(__file__).parents[2] / "golden" / "cases" / "plan.json"
PLAN_CASES = [
    case for case in read_cases(GOLDEN, KINDS, command="test") if isinstance(case, PlanCase)
]
NOT_A_POMDP = ("factorized", "hypothesis_independent_future", "no_defer")
SAYABLE = [
    case for case in PLAN_CASES if not any(getattr(case.options, name) for name in NOT_A_POMDP)
]


@st.composite
def problems(draw: st.DrawFn, most_tracks: int = 3) -> Problem:
    """Decision problems of all kinds, with belief and counts drawn from few random numbers."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(1, most_tracks))
    masses = rng.gamma(draw(st.sampled_from([0.1, 0.3, 1.0])), size=2 * n + 2) + 1e-12
    p = masses / masses.sum()
    tracks = tuple(int(i) for i in np.cumsum(rng.integers(1, 4, n)))
    rows = draw(st.sampled_from((simulated_cell().informs, EXTENDED.rows(simulated_cell()))))
    return Problem(
        belief=JointBelief(tracks, p[:-2].reshape(n, 2), float(p[-2]), float(p[-1])),
        y0=tuple(draw(st.sampled_from((None, *OBSERVATIONS))) for _ in tracks),
        state=draw(st.sampled_from(("open", "covered"))),
        used=frozenset(draw(st.sets(st.sampled_from(("right", "close_high")), max_size=1))),
        feasible=frozenset(draw(st.sets(st.sampled_from(tracks)))),
        asked=draw(st.sampled_from(("inside", "outside", "any"))),
        q_hat=draw(st.sampled_from((0.5, 0.9, 0.99, np.inf))),
        horizon=draw(st.integers(1, 3)),
        rows=rows,
        future=FutureModel(Emission({q: counts(rng) for q in ("center", "right")}), {
            row.name: {y0: counts(rng) for y0 in OBSERVATIONS[:3]} for row in rows
        }),
        p_remove=0.8,
        p_grasp=6 / 7,
        options=Options(no_risk=draw(st.booleans()), no_conformal=draw(st.booleans())),
    )  # fmt: skip


def counts(rng: np.random.Generator) -> dict[str, tuple[int, ...]]:
    return {name: tuple(map(int, rng.integers(0, 20, len(OBSERVATIONS)))) for name in CLASSES}


@pytest.mark.parametrize("case", SAYABLE, ids=lambda case: case.name)
def test_a_golden_case_read_back_is_worth_what_was_promised(case: PlanCase) -> None:
    problem = case.problem()
    reward = read(pomdpx.document(problem, case.name)).value()
    assert -reward == pytest.approx(value(problem), rel=1e-9)
    assert value(problem) <= solve(problem).value + 1e-12


@settings(deadline=None, max_examples=12)
@given(problems())
def test_any_problem_read_back_is_worth_what_was_promised(problem: Problem) -> None:
    reward = read(pomdpx.document(problem, "drawn")).value()
    assert -reward == pytest.approx(value(problem), rel=1e-9)


@settings(deadline=None, max_examples=60)
@given(problems())
def test_without_the_rules_on_the_belief_it_never_costs_more(problem: Problem) -> None:
    assert value(problem) <= solve(problem).value + 1e-12


@settings(deadline=None, max_examples=60)
@given(problems(), st.sampled_from(("open", "covered")))
def test_where_these_rules_forbid_nothing_it_costs_what_the_search_says(
    problem: Problem, state: State
) -> None:
    """Everything stands outside and can be grasped there, and abstaining never pays."""
    belief = problem.belief
    outside = belief.p_tracked * [0.0, 1.0] + [0.0, 1e-3]
    total = outside.sum() + belief.p_unobs
    ruled = replace(
        problem,
        belief=JointBelief(belief.tracks, outside / total, belief.p_unobs / total, 0.0),
        state=state,
        asked="outside",
        feasible=frozenset(belief.tracks),
        costs=Costs(defer=1.0079),
        options=replace(problem.options, no_conformal=True),
    )
    assert value(ruled) == pytest.approx(solve(ruled).value, rel=1e-9)


@pytest.mark.parametrize("case", PLAN_CASES, ids=lambda case: case.name)
def test_what_a_pomdp_cannot_say_is_refused(case: PlanCase) -> None:
    if case in SAYABLE:
        appearing = replace(case.problem(), p_appears={"right": 0.1})
        with pytest.raises(ValueError, match="appear"):
            pomdpx.document(appearing, case.name)
        if len(case.tracks) > 1:
            with pytest.raises(ValueError, match="some tracks only"):
                pomdpx.document(replace(case.problem(), n_foreseen=1), case.name)
    else:
        with pytest.raises(ValueError, match="cannot say"):
            pomdpx.document(case.problem(), case.name)


def test_the_file_says_what_is_left_out_and_which_tracks_are_out_of_reach() -> None:
    case = next(case for case in SAYABLE if case.name == "infeasible_at_root")
    written = pomdpx.document(case.problem(), "<this & that>").decode()
    assert "&lt;this &amp; that&gt;" in written
    assert "NOT here" in written and "Before the first look t1 cannot be grasped." in written


def test_the_command_writes_one_case_and_says_what_it_costs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "look.pomdpx"
    assert cases.main([str(GOLDEN), "--case", "tiny_look", "--export", "pomdpx", str(file)]) == 0
    (told,) = json.loads(capsys.readouterr().out)
    assert told["name"] == "tiny_look" and told["file"] == str(file)
    assert -read(file.read_bytes()).value() == pytest.approx(told["V"], rel=1e-9)


@pytest.mark.parametrize(
    ("more", "told"),
    [
        (["--case", "no such", "--export", "pomdpx", "FILE"], "tiny_look"),
        (["--export", "pomdpx", "FILE"], "--case NAME"),
        (["--case", "tiny_look", "--export", "cassandra", "FILE"], "Formats: pomdpx"),
        (["--case", "no_defer_open", "--export", "pomdpx", "FILE"], "no_defer_open: a POMDP"),
        (["--case", "tiny_look", "--export", "pomdpx", "DIR"], "cannot be written"),
    ],
)
def test_the_command_says_what_it_cannot_export(tmp_path: Path, more: list[str], told: str) -> None:
    places = {"FILE": str(tmp_path / "file"), "DIR": str(tmp_path)}
    with pytest.raises(BadInput, match=told):
        cases.main([str(GOLDEN), *(places.get(word, word) for word in more)])
    assert not (tmp_path / "file").exists()
