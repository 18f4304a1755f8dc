"""What comes of a removal and a grasp is measured on a table of its own, and kept."""

from pathlib import Path

import msgspec
import pytest
from numpy.random import default_rng
from recorded_table import record
from scripted_table import Table

from surefetch.common.cell import InformRow, simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.messages import Grasp
from surefetch.common.parameters import shipped_parameters
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.recordings.measured import FORMAT, MOST_ATTEMPTS, Attempt, Measured
from surefetch.evaluation.recordings.studio import Recorded, Studio
from surefetch.evaluation.replaying.episode import Errand, play
from surefetch.evaluation.replaying.measure import RULES, Instructed, Site, measure
from surefetch.evaluation.replaying.nudged_world import GraspMeasured, RemovalMeasured
from surefetch.evaluation.replaying.world import Report
from surefetch.evaluation.scenes.generate import generate
from surefetch.executor.simulation.scene_bodies import LID
from surefetch.planner.episode_state import EpisodeState

CELL = simulated_cell()
NUMBERS = shipped_parameters("extended")
DONE = Attempt(done=True, why="", moved_m=0.0, turned_deg=0.0, duration_s=1.0)
FAILED = Attempt(done=False, why="it slipped", moved_m=0.01, turned_deg=0.0, duration_s=1.0)


@pytest.fixture(scope="module")
def recorded() -> Recorded:
    """A covered scene, its target outside."""
    with Studio(generate("visible", 9), CELL, "classical") as studio:
        return studio.record()


def test_a_cover_is_removed_a_target_grasped_and_the_table_stays_as_it_was(
    recorded: Recorded,
) -> None:
    measured = measure(recorded.recording, recorded.truth, CELL, NUMBERS)
    assert recorded.recording.covered
    for attempts in (measured.removals, measured.grasps):
        assert 1 <= len(attempts) <= MOST_ATTEMPTS
        assert [attempt.done for attempt in attempts] == [False] * (len(attempts) - 1) + [True]
        assert not attempts[-1].disturbed
        assert attempts[-1].duration_s > 1.0


class KnocksTheLid(RemovalMeasured):
    """A robot that pushes the lid and says that it failed."""

    def try_inform(self, row: InformRow) -> Report:  # noqa: ARG002
        self.shift(LID, (0.01, 0.0), 0.0)
        return Report(done=False, why="it slipped")


class HoldsNothing(GraspMeasured):
    """A robot that says that it holds the target, with empty fingers."""

    def try_grasp(self, grasp: Grasp, state: EpisodeState) -> Report:  # noqa: ARG002
        return Report(done=True)


def site(recorded: Recorded) -> Site:
    recording = recorded.recording
    return Site(generate(recording.family, recording.seed), recording, CELL, NUMBERS)


def test_a_lid_that_was_pushed_is_a_thing_that_was_moved(recorded: Recorded) -> None:
    with site(recorded).table(KnocksTheLid, 1) as table:
        table.inform(next(row for row in CELL.informs if row.kind == "remove_cover"))
        (attempt,) = table.attempts
    assert attempt.moved_m == pytest.approx(0.01, abs=1e-6)
    assert attempt.disturbed


def test_whoever_holds_something_else_than_the_target_has_failed(recorded: Recorded) -> None:
    with site(recorded).table(HoldsNothing, 1) as table:
        instructed = Instructed(recorded.truth.target, False, table.bodies)
        errand = Errand(recorded.recording.target, CELL, NUMBERS, RULES)
        end = play(instructed, errand, table, site(recorded).beliefs(), default_rng(0)).end
        (attempt,) = table.attempts
    assert (attempt.done, end.outcome) == (False, "failed")


def test_where_nothing_is_to_be_had_nothing_is_tried() -> None:
    recording, truth = record(Table([]), wanted=None)
    measured = measure(recording, truth, CELL, NUMBERS)
    assert (measured.removals, measured.grasps) == ((), ())


def test_a_body_that_was_pushed_or_turned_makes_the_recording_invalid() -> None:
    assert FAILED.disturbed
    assert msgspec.structs.replace(DONE, turned_deg=3.0).disturbed
    assert not DONE.disturbed


def test_measured_outcomes_are_read_back_and_asked_for_where_they_are_missing(
    tmp_path: Path,
) -> None:
    kept = Measured(format=FORMAT, family="visible", seed=7, removals=(), grasps=(FAILED, DONE))
    with pytest.raises(BadInput, match="surefetch study measure"):
        recording_store.load_measured(tmp_path, "visible", 7)
    recording_store.save_measured(tmp_path, kept)
    assert recording_store.load_measured(tmp_path, "visible", 7) == kept
    newer = msgspec.structs.replace(kept, format=FORMAT + 1)
    recording_store.save_measured(tmp_path, newer)
    with pytest.raises(BadInput, match="Measure it again"):
        recording_store.load_measured(tmp_path, "visible", 7)
