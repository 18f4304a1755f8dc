"""What of numbers and rules becomes part of the decision problem."""

import msgspec
import pytest
from scripted_table import CELL, parameters

from surefetch.common.messages import BeliefReply, Feasibility, Target
from surefetch.common.parameters import BirthCounts, Parameters
from surefetch.planner.decide import problem_of
from surefetch.planner.problem import Problem
from surefetch.planner.profiles import EXTENDED, PAPER, Policy, Profile
from surefetch.planner.search import solve
from surefetch.planner.situation import Errand, Situation


def problem(numbers: Parameters, profile: Profile = EXTENDED) -> Problem:
    believed = BeliefReply(
        episode="e", step=0, tracks=(), assigned=(), prior={}, belief={"unobs": 0.7, "abs": 0.3},
        gamma=("unobs", "abs"), q_hat=0.9, digest="-",
    )  # fmt: skip
    errand = Errand(
        Target(noun="object", color="red"), "hold", Policy("p", profile, solve), numbers, CELL
    )
    nothing = Feasibility(grasps=(), informs=(), duration_s=0.0)
    return problem_of(errand, Situation(believed, "covered", frozenset(), frozenset(), nothing))


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
