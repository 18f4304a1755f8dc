"""The search is exact: it finds what a plain recursion over single beliefs finds."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.cell import InformRow, simulated_cell
from surefetch.common.conformal import conformal_set
from surefetch.common.emission import Emission
from surefetch.common.hypotheses import ABS, CLASSES, OBSERVATIONS, RELATIONS
from surefetch.common.joint_belief import JointBelief
from surefetch.planner import actions
from surefetch.planner.actions import State
from surefetch.planner.enumeration import Enumeration
from surefetch.planner.futures import FutureModel
from surefetch.planner.outcome_grid import FEW
from surefetch.planner.problem import Options, Problem
from surefetch.planner.profiles import EXTENDED
from surefetch.planner.search import solve

ROWS = simulated_cell().informs
MORE_ROWS = EXTENDED.rows(simulated_cell())
A_VIEW_FROM_THE_LEFT = InformRow(
    name="left", kind="view", view="right", cost=0.006, requires="open", q="left"
)


@st.composite
def problems(draw: st.DrawFn, most_tracks: int = 3, least_tracks: int = 1) -> Problem:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(least_tracks, most_tracks))
    masses = rng.gamma(draw(st.sampled_from([0.1, 0.3, 1.0, 3.0])), size=2 * n + 2) + 1e-12
    p = masses / masses.sum()
    counts = {
        q: {c: tuple(map(int, rng.integers(0, 40, len(OBSERVATIONS)))) for c in CLASSES}
        for q in ("center", "right", "close_high", "after_removal")
    }
    paired = {
        row.name: {
            y0: {c: tuple(map(int, rng.integers(0, 9, len(OBSERVATIONS)))) for c in CLASSES}
            for y0 in OBSERVATIONS[:3]
        }
        for row in MORE_ROWS
    }
    tracks = tuple(range(1, n + 1))
    return Problem(
        belief=JointBelief(tracks, p[:-2].reshape(n, 2), float(p[-2]), float(p[-1])),
        y0=tuple(draw(st.sampled_from((None, *OBSERVATIONS))) for _ in tracks),
        state=draw(st.sampled_from(("open", "covered"))),
        used=frozenset(draw(st.sets(st.sampled_from(("right", "close_high")), max_size=1))),
        feasible=frozenset(draw(st.sets(st.sampled_from(tracks)))),
        asked=draw(st.sampled_from(("inside", "outside", "any"))),
        q_hat=draw(st.sampled_from((0.05, 0.5, 0.65, 0.9, 0.937, 0.99, np.inf))),
        horizon=draw(st.integers(0, 3)),
        rows=draw(st.sampled_from((ROWS, MORE_ROWS))),
        future=FutureModel(Emission(counts), paired),
        p_remove=0.8,
        p_grasp=6 / 7,
        options=Options(
            no_risk=draw(st.booleans()),
            no_conformal=draw(st.booleans()),
            no_defer=draw(st.booleans()),
        ),
        n_foreseen=draw(st.sampled_from((None, 1, 2, 3))),
        defer_at_least=draw(st.sampled_from((0.0, 0.6))),
        commit_at_least=draw(st.sampled_from((0.0, 0.3, 0.8))),
        p_appears=draw(st.sampled_from(({}, {row.name: float(rng.random()) for row in MORE_ROWS}))),
    )


def plain_q(p: Problem, row: InformRow) -> float:
    """Q of an information action at the root: one belief after another, nothing merged."""
    return _looking(p, p.belief, row, p.state, p.used, p.horizon)


def _looking(
    p: Problem, b: JointBelief, row: InformRow, state: State, used: frozenset[str], depth: int
) -> float:
    used = used | {row.name}
    value = row.cost
    for s, p_state in actions.transitions(row, state, p.p_remove):
        hidden = row.kind == "remove_cover" and s == "covered"
        found = 0.0 if hidden else b.p_unobs * p.p_appears.get(row.name, 0.0)
        missed = replace(b, p_unobs=b.p_unobs - found)
        value += p_state * found * actions.grasp_cost(1.0, p.p_held, p.costs)
        for after, p_shown in _after(p, missed, row):
            value += p_state * p_shown * _value(p, after, s, used, depth - 1)
    return value


def _after(p: Problem, b: JointBelief, row: InformRow) -> Iterator[tuple[JointBelief, float]]:
    """What one track may show; beliefs need not sum to 1, and the chances sum to what they do."""
    foreseen = sorted(range(len(b.tracks)), key=lambda i: -p.belief.p_tracked[i].sum())
    foreseen = foreseen[: p.n_foreseen]
    for i in foreseen:
        E = p.future.likelihood(row, p.y0[i])
        for y in range(len(OBSERVATIONS)):
            tracked = b.p_tracked * E[2, y]
            tracked[i] = b.p_tracked[i] * E[:2, y]
            unobs, absent = b.p_unobs * E[2, y], b.p_abs * E[2, y]
            total = tracked.sum() + unobs + absent
            yield (
                JointBelief(b.tracks, tracked / total, unobs / total, absent / total),
                total / len(foreseen),
            )


def _value(p: Problem, b: JointBelief, state: State, used: frozenset[str], depth: int) -> float:
    informs = actions.expandable(p.rows, state, used) if depth > 0 else ()
    gamma = conformal_set(b.named(), p.q_hat)
    ends = [
        actions.grasp_cost(c.p, p.p_held, p.costs)
        for c in actions.candidates(b, p.asked, state)
        if p.options.no_conformal
        or (actions.semantically_eligible(c, gamma, p.asked) and c.p >= p.commit_at_least)
    ]
    absent = gamma == (ABS,) and b.p_abs >= p.defer_at_least
    if (not informs or absent) and not p.options.no_defer:
        ends.append(actions.defer_cost(b.p_abs, p.costs))
    looks = [_looking(p, b, row, state, used, depth) for row in informs]
    return min([*ends, *looks], default=p.costs.stalled)


@settings(deadline=None, max_examples=40)
@given(problems(most_tracks=2))
def test_every_action_is_worth_what_a_plain_recursion_says(problem: Problem) -> None:
    found = {q.action: q.value for q in solve(problem).q_values if q.track is None}
    for row in actions.expandable(problem.rows, problem.state, problem.used):
        if problem.horizon > 0:
            assert found[row.name] == pytest.approx(plain_q(problem, row), rel=1e-9)


@settings(deadline=None, max_examples=60)
@given(problems(most_tracks=9))
def test_merging_equals_enumerating_with_many_tracks(problem: Problem) -> None:
    enumeration = Enumeration(problem)
    for q in solve(problem).q_values:
        if q.action not in ("grasp", "defer"):
            row = next(row for row in problem.rows if row.name == q.action)
            assert q.value == pytest.approx(enumeration.q(row), rel=1e-9)


@settings(deadline=None, max_examples=15)
@given(problems(least_tracks=4, most_tracks=5))
def test_leaving_out_what_cannot_win_equals_enumerating(problem: Problem) -> None:
    everything = replace(problem, n_foreseen=None, horizon=3, used=frozenset())
    assert (7 * len(problem.belief.tracks)) ** 3 > FEW
    enumeration = Enumeration(everything)
    for q in solve(everything).q_values:
        if q.action not in ("grasp", "defer"):
            row = next(row for row in everything.rows if row.name == q.action)
            assert q.value == pytest.approx(enumeration.q(row), rel=1e-9)


@settings(deadline=None, max_examples=15)
@given(problems(most_tracks=5))
def test_a_view_more_is_a_row_more(problem: Problem) -> None:
    wider = replace(problem, rows=(*problem.rows, A_VIEW_FROM_THE_LEFT), state="open")
    enumeration = Enumeration(wider)
    for q in solve(wider).q_values:
        if q.action not in ("grasp", "defer"):
            row = next(row for row in wider.rows if row.name == q.action)
            assert q.value == pytest.approx(enumeration.q(row), rel=1e-9)


@settings(deadline=None)
@given(problems())
def test_no_grasp_is_open_unless_the_set_holds_it_alone(problem: Problem) -> None:
    solution = solve(replace(problem, options=Options()))
    relations = RELATIONS if problem.asked == "any" else (problem.asked,)
    allowed = [z for z in solution.gamma if z.partition(":")[2] in relations]
    for q in solution.q_values:
        if q.action == "grasp":
            assert allowed == [f"{q.track}:{q.relation}"]
            assert q.track in problem.feasible
            assert problem.belief.named()[f"{q.track}:{q.relation}"] >= problem.commit_at_least
            assert problem.state == "open" or q.relation != "inside"


@settings(deadline=None)
@given(problems())
def test_defer_is_open_only_when_nothing_is_left_to_look_at_or_absence_is_sure(
    problem: Problem,
) -> None:
    solution = solve(replace(problem, options=Options()))
    actions_open = [q.action for q in solution.q_values]
    if "defer" in actions_open:
        sure = solution.gamma == (ABS,) and problem.belief.p_abs >= problem.defer_at_least
        assert sure or set(actions_open) <= {"grasp", "defer"}


@settings(deadline=None)
@given(problems())
def test_the_same_problem_has_the_same_solution_bit_for_bit(problem: Problem) -> None:
    first, second = solve(problem), solve(problem)
    assert first.q_values == second.q_values
    assert first.chosen == second.chosen


@settings(deadline=None, max_examples=25)
@given(problems())
def test_names_of_tracks_do_not_matter(problem: Problem) -> None:
    shift = 10
    belief = problem.belief
    renamed = replace(
        problem,
        belief=replace(belief, tracks=tuple(i + shift for i in belief.tracks)),
        feasible=frozenset(i + shift for i in problem.feasible),
    )
    values = [q.value for q in solve(problem).q_values]
    assert [q.value for q in solve(renamed).q_values] == values


def test_what_may_appear_under_the_lid_makes_opening_it_worth_its_cost() -> None:
    problem = Problem(
        belief=JointBelief((), np.zeros((0, 2)), 0.6, 0.4),
        y0=(),
        state="covered",
        used=frozenset(),
        feasible=frozenset(),
        asked="inside",
        q_hat=0.9,
        horizon=1,
        rows=ROWS,
        future=FutureModel(Emission({}), {}),
        p_remove=0.8,
        p_grasp=0.9,
        p_appears={"remove_cover": 0.5},
    )
    found, missed = 0.6 * 0.5 * (0.008 + 0.5 * 0.1), 0.6 * 0.5 * 0.8
    (opening,) = solve(problem).q_values
    assert opening.value == pytest.approx(0.16 + 0.8 * (found + missed) + 0.2 * 0.6 * 0.8)
