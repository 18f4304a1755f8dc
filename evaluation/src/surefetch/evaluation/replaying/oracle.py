"""The upper bound: knows the truth, and suffers only what comes of its actions. No policy."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from surefetch.common.cell import Cell
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.scoring import marked, result
from surefetch.evaluation.replaying.world import OutOfRecording, Report
from surefetch.evaluation.running.metrics import Verdict
from surefetch.planner.actions import Costs


@dataclass(frozen=True)
class Try:
    """One action, and what came of it."""

    word: str
    cost: float
    report: Report


def play_oracle(
    one: Contender, scene: RecordedScene, world: RecordedWorld, cell: Cell
) -> EpisodeResult:
    """Opens only when the target lies under the cover, grasps it, defers when it is absent."""
    truth, at_most = scene.truth, one.profile.tries
    if truth.target is None:
        return _result(one, scene, "success", [])
    tried: list[Try] = []
    if scene.recording.covered and truth.relation == "inside":
        row = next(row for row in cell.informs if row.kind == "remove_cover")
        reports = _persist(lambda: world.inform(row), at_most)
        tried += [Try(row.name, row.cost, report) for report in reports]
        if not reports[-1].done:
            return _result(one, scene, "interaction_failed", tried)
    reports = _persist(lambda: world.grasp_body(truth.target), at_most)
    tried += [Try("grasp the target", Costs().grasp, report) for report in reports]
    return _result(one, scene, "success" if reports[-1].done else "grasp_failed", tried)


def _persist(attempt: Callable[[], Report], at_most: int) -> list[Report]:
    """Attempts up to the first that succeeds; one that the robot found no way to make fails."""
    reports: list[Report] = []
    while len(reports) < at_most and not (reports and reports[-1].done):
        try:
            reports.append(attempt())
        except OutOfRecording as error:
            reports.append(Report(done=False, why=str(error)))
    return reports


def _result(
    one: Contender, scene: RecordedScene, found: Verdict, tried: Sequence[Try]
) -> EpisodeResult:
    return result(
        one,
        scene,
        found,
        cost=sum(one.cost for one in tried),
        n_actions=len(tried),
        outcome={"success": "grasped" if tried else "deferred"}.get(found, "failed"),
        reason="",
        why="",
        actions=tuple(marked(t.word, t.report) for t in tried) or ("defer",),
        duration_s=sum(t.report.duration_s for t in tried),
        commit_p=float(bool(tried)),
        grasps=(),
        steps=(),
    )
