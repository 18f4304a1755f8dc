"""What of numbers and rules becomes part of the decision problem, and of the decision."""

import msgspec
import pytest
from made_up_looks import track
from scripted_table import CELL, parameters

from surefetch.common.conformal import conformal_set
from surefetch.common.messages import BeliefReply, Defer, Feasibility, GraspVerdict, Target
from surefetch.common.parameters import BirthCounts, Parameters
from surefetch.planner.decide import Decision, decide, problem_of
from surefetch.planner.problem import Problem
from surefetch.planner.profiles import EXTENDED, PAPER, Policy, Profile
from surefetch.planner.search import solve
from surefetch.planner.situation import Errand, Situation

NO_GRASP = Feasibility(grasps=(), informs=(), duration_s=0.0)


def problem(numbers: Parameters, profile: Profile = EXTENDED) -> Problem:
    believed = told({"unobs": 0.7, "abs": 0.3}, q_hat=0.9)
    now = Situation(believed, "covered", frozenset(), frozenset(), NO_GRASP)
    return problem_of(errand(numbers, profile), now)


def errand(numbers: Parameters, profile: Profile = EXTENDED) -> Errand:
    target = Target(noun="object", color="red")
    return Errand(target, "hold", Policy("p", profile, solve), numbers, CELL)


def told(belief: dict[str, float], q_hat: float) -> BeliefReply:
    """Track 1 is there if the belief has it."""
    return BeliefReply(
        episode="e", step=0, tracks=(track(1, "MO"),) if "1:outside" in belief else (),
        assigned=(), prior={}, belief=belief, gamma=conformal_set(belief, q_hat), q_hat=q_hat,
        digest="-",
    )  # fmt: skip


def appeared(times: int) -> BirthCounts:
    return BirthCounts(with_target=(times, 0), without=(0, 0, 0), still_unseen=8 - times)


def test_how_often_a_target_appears_is_that_of_the_look_with_the_cover_as_it_is_then() -> None:
    births = {
        "right": {"covered": appeared(1), "open": appeared(2)},
        "close_high": {"open": appeared(3)},
        "after_removal": {"open": appeared(7)},
    }
    found = problem(msgspec.structs.replace(parameters("extended"), births=births)).p_appears
    assert found == pytest.approx(
        {"right": 0.3, "close_high": 0.4, "remove_cover": 0.8}
        | {"right_covered": 0.2, "close_high_covered": 0.0}
    )


def test_nothing_appears_where_that_was_not_fitted() -> None:
    assert set(problem(parameters("extended")).p_appears.values()) == {0.0}


def test_the_profile_paper_decides_by_the_papers_rules_alone() -> None:
    plain = problem(parameters("paper"), PAPER)
    assert plain.rows == CELL.informs
    assert (plain.n_foreseen, plain.defer_at_least, plain.commit_at_least) == (None, 0.0, 0.0)
    assert set(plain.p_appears.values()) == {0.0}


def test_the_least_belief_for_a_grasp_is_the_fitted_one() -> None:
    careful = msgspec.structs.replace(parameters("extended"), commit_at_least=0.4)
    assert problem(careful).commit_at_least == 0.4


def when_a_look_failed_for_good(p_abs: float, profile: Profile) -> Decision:
    believed = told({"unobs": 1.0 - p_abs, "abs": p_abs}, q_hat=0.5)
    used, given_up = frozenset({"close_high"}), frozenset({"right"})
    now = Situation(believed, "open", used, given_up, NO_GRASP)
    return decide(errand(parameters(profile.name), profile), now)


def test_a_look_that_failed_opens_abstaining_no_earlier_than_a_look_to_take() -> None:
    assert when_a_look_failed_for_good(0.69, EXTENDED).choice is None
    assert when_a_look_failed_for_good(0.71, EXTENDED).choice == Defer()
    assert when_a_look_failed_for_good(0.51, PAPER).choice == Defer()
    assert when_a_look_failed_for_good(0.49, PAPER).choice is None


@pytest.mark.parametrize("at_least", [0.0, 0.8])
def test_that_a_belief_is_too_little_for_a_grasp_is_said(at_least: float) -> None:
    belief = {"1:inside": 0.1, "1:outside": 0.7, "unobs": 0.1, "abs": 0.1}
    reach = GraspVerdict(track=1, feasible=True, refusal=None, why="", tried={})
    now = Situation(
        told(belief, q_hat=0.5), "open", frozenset(row.name for row in CELL.informs), frozenset(),
        Feasibility(grasps=(reach,), informs=(), duration_s=0.0),
    )  # fmt: skip
    numbers = msgspec.structs.replace(parameters("extended"), commit_at_least=at_least)
    decision = decide(errand(numbers), now)
    assert (decision.choice == Defer()) == (at_least == 0.8)
    assert ("but a grasp takes a belief of 0.800" in decision.because) == (at_least == 0.8)
