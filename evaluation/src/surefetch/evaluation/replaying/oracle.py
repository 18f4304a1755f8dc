"""The upper bound: knows the truth, and suffers only what comes of its actions. No policy."""

from collections.abc import Callable

from surefetch.common.cell import Cell
from surefetch.evaluation.recordings.recording import RecordingTruth
from surefetch.evaluation.replaying.outcomes import Outcomes
from surefetch.evaluation.running.metrics import Scored, Verdict
from surefetch.planner.actions import Costs
from surefetch.planner.profiles import Profile


def play_oracle(
    truth: RecordingTruth, covered: bool, profile: Profile, outcomes: Outcomes, cell: Cell
) -> Scored:
    """Opens only when the target lies under the cover, grasps it, defers when it is absent."""
    if truth.target is None:
        return Scored(truth.family, truth.seed, "success", 0, 0.0)
    actions, cost = 0, 0.0
    if covered and truth.relation == "inside":
        row = next(row for row in cell.informs if row.kind == "remove_cover")
        opened, tries = _persist(lambda n: outcomes.informs(row, n), profile.tries)
        actions, cost = tries, tries * row.cost
        if not opened:
            return Scored(truth.family, truth.seed, "interaction_failed", actions, cost)
    held, tries = _persist(lambda n: outcomes.grasps(truth.target, n), profile.tries)
    actions, cost = actions + tries, cost + tries * Costs().grasp
    verdict: Verdict = "success" if held else "grasp_failed"
    return Scored(truth.family, truth.seed, verdict, actions, cost)


def _persist(succeeds: Callable[[int], bool], at_most: int) -> tuple[bool, int]:
    """Whether it succeeds in the end, and after how many tries."""
    for attempt in range(1, at_most + 1):
        if succeeds(attempt):
            return True, attempt
    return False, at_most
