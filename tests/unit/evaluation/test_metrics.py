"""Episodes are counted as the tables say, and intervals are the printed ones."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from surefetch.evaluation.running.metrics import (
    Scored,
    Verdict,
    by_family,
    failure_classes,
    mcnemar,
    realized_cost,
    verdict,
    wilson,
)


@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [(7, 25, 14.2839, 47.5766), (19, 25, 56.5703, 88.5037), (13, 25, 33.4985, 69.9687)],
)
def test_the_interval_is_the_one_that_the_paper_prints(
    successes: int, n: int, low: float, high: float
) -> None:
    assert [100 * bound for bound in wilson(successes, n)] == pytest.approx([low, high], abs=1e-4)


def test_nothing_observed_leaves_everything_possible() -> None:
    assert wilson(0, 0) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("outcome", "reason", "target", "grasped", "expected"),
    [
        ("grasped", "verified", "a", ["a"], "success"),
        ("grasped", "verified", "a", ["b"], "wrong_object"),
        ("grasped", "verified", "a", ["b", "a"], "wrong_object"),
        ("grasped", "verified", None, ["b"], "wrong_object"),
        ("grasped", "verified", "a", [], "wrong_object"),
        ("deferred", "absent", None, [], "success"),
        ("deferred", "absent", "a", [], "false_defer"),
        ("failed", "grasp_failed", "a", ["a"], "grasp_failed"),
        ("failed", "grasp_failed", "a", ["b"], "wrong_object"),
        ("failed", "grasp_failed", None, [], "wrong_object"),
        ("deferred", "no_view_left", "a", ["b"], "wrong_object"),
        ("failed", "removal_failed", "a", [], "interaction_failed"),
        ("failed", "step_limit", "a", [], "step_limit"),
        ("stalled", "nothing_admissible", "a", [], "stalled"),
        ("aborted", "perception_missing", "a", ["b"], "aborted"),
    ],
)
def test_an_episode_is_counted_by_what_the_fingers_held(
    outcome: str, reason: str, target: str | None, grasped: list[str], expected: str
) -> None:
    assert verdict(outcome, reason, target=target, grasped=grasped) == expected


@pytest.mark.parametrize("outcome", ["deferred", "failed", "stalled"])
def test_a_target_that_nobody_ever_saw_is_a_failure_of_perception(outcome: str) -> None:
    found = verdict(outcome, "no_view_left", target="a", grasped=[], anything_seen=False)
    assert found == "perception_failure"
    assert verdict("deferred", "absent", target=None, grasped=[], anything_seen=False) == "success"


@given(st.lists(st.sampled_from(["success", "wrong_object", "false_defer", "stalled"])))
def test_the_classes_sum_to_the_episodes(verdicts: list[Verdict]) -> None:
    episodes = [Scored("covered", seed, v, 1, 0.0) for seed, v in enumerate(verdicts)]
    assert sum(failure_classes(episodes).values()) == len(episodes)
    assert sum(r["episodes"] for r in by_family(episodes).values()) == len(episodes)


def test_a_wrong_grasp_costs_more_than_a_defer_and_a_defer_more_than_success() -> None:
    costs = [
        realized_cost(Scored("partial", 1, v, 1, 0.012))
        for v in ("success", "false_defer", "wrong_object")
    ]
    assert costs == pytest.approx([0.012, 0.812, 1.012])


def test_two_that_never_differ_cannot_be_told_apart() -> None:
    assert mcnemar(0, 0) == 1.0
    assert mcnemar(12, 0) == pytest.approx(2 * 0.5**12)
