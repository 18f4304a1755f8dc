"""Episodes to successes, failure classes and intervals. Pure."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

from scipy import stats

Verdict = Literal[
    "success",
    "false_defer",
    "wrong_object",
    "grasp_failed",
    "interaction_failed",
    "step_limit",
    "stalled",
    "perception_failure",
    "aborted",
    "stopped",
]
VERDICTS: Final[tuple[Verdict, ...]] = get_args(Verdict)
"""Success and the failure classes; they sum to the number of episodes."""


@dataclass(frozen=True)
class Scored:
    """One episode as the tables count it."""

    family: str
    seed: int
    verdict: Verdict
    actions: int
    cost: float
    """Sum of the planner's constants of the actions taken."""


def verdict(
    outcome: str,
    reason: str,
    *,
    target: str | None,
    grasped: Sequence[str],
    anything_seen: bool = True,
) -> Verdict:
    """How the scorer counts an episode.

    Args:
        outcome: as the planner reported it.
        reason: as the planner reported it; tells the step limit from a failed interaction.
        target: the body asked for, None when the table does not hold it.
        grasped: bodies that both fingers closed on, in order.
        anything_seen: whether any candidate reached the belief.

    Returns:
        success when the target was grasped, or nothing was there to grasp and the end was a defer.
    """
    if outcome == "aborted":
        return "aborted"
    if outcome == "stopped":
        return "stopped"
    tried_to_grasp = outcome == "grasped" or reason.startswith("grasp")
    if any(body != target for body in grasped) or (tried_to_grasp and target is None):
        return "wrong_object"
    if outcome == "grasped" and not grasped:
        return "wrong_object"
    if outcome == "grasped" or (outcome == "deferred" and target is None):
        return "success"
    if not anything_seen:
        return "perception_failure"
    if outcome == "deferred":
        return "false_defer"
    if outcome == "stalled":
        return "stalled"
    if reason == "step_limit":
        return "step_limit"
    return "grasp_failed" if tried_to_grasp else "interaction_failed"


def realized_cost(scored: Scored) -> float:
    """The planner's own objective, with what really happened in it."""
    terminal = {"wrong_object": 1.0, "grasp_failed": 0.5, "false_defer": 0.8}
    return scored.cost + terminal.get(scored.verdict, 0.0)


def wilson(successes: int, n: int) -> tuple[float, float]:
    """The 95 % Wilson score interval without continuity correction; (0, 1) of nothing.

    Source: Wilson, Probable inference, the law of succession, and statistical inference (1927).
    """
    if n == 0:
        return 0.0, 1.0
    interval = stats.binomtest(successes, n).proportion_ci(confidence_level=0.95, method="wilson")
    return float(interval.low), float(interval.high)


def mcnemar(only_a: int, only_b: int) -> float:
    """The exact two-sided p value of paired successes; 1 when the two never differ."""
    if only_a + only_b == 0:
        return 1.0
    return float(stats.binomtest(only_a, only_a + only_b, 0.5).pvalue)


def by_family(episodes: Sequence[Scored]) -> dict[str, dict[str, Any]]:
    """Per family, in order of appearance: episodes, successes, interval, wrong and false ends."""
    families = dict.fromkeys(episode.family for episode in episodes)
    return {
        family: row([episode for episode in episodes if episode.family == family])
        for family in families
    }


def row(episodes: Sequence[Scored]) -> dict[str, Any]:
    """One row of a table."""
    counts = Counter(episode.verdict for episode in episodes)
    return {
        "episodes": len(episodes),
        "successes": counts["success"],
        "wilson_95": list(wilson(counts["success"], len(episodes))),
        "wrong_object": counts["wrong_object"],
        "false_defers": counts["false_defer"],
    }


def failure_classes(episodes: Sequence[Scored]) -> Mapping[str, int]:
    """How often each verdict was given, in the order of `VERDICTS`, zeros included."""
    counts = Counter(episode.verdict for episode in episodes)
    return {name: counts[name] for name in VERDICTS}
