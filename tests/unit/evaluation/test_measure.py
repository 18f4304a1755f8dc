"""What comes of a removal and a grasp is measured on a table of its own, and kept."""

from pathlib import Path

import msgspec
import pytest
from recorded_table import record
from scripted_table import Table

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.parameters import shipped_parameters
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.recordings.measured import FORMAT, MOST_ATTEMPTS, Attempt, Measured
from surefetch.evaluation.recordings.studio import Studio
from surefetch.evaluation.replaying.measure import measure
from surefetch.evaluation.scenes.generate import generate

CELL = simulated_cell()
NUMBERS = shipped_parameters("extended")
DONE = Attempt(done=True, why="", moved_m=0.0, turned_deg=0.0, duration_s=1.0)
FAILED = Attempt(done=False, why="it slipped", moved_m=0.01, turned_deg=0.0, duration_s=1.0)


def test_a_cover_is_removed_a_target_grasped_and_the_table_stays_as_it_was() -> None:
    with Studio(generate("visible", 9), CELL, "classical") as studio:
        recorded = studio.record()
    measured = measure(recorded.recording, recorded.truth, CELL, NUMBERS)
    assert recorded.recording.covered
    for attempts in (measured.removals, measured.grasps):
        assert 1 <= len(attempts) <= MOST_ATTEMPTS
        assert [attempt.done for attempt in attempts] == [False] * (len(attempts) - 1) + [True]
        assert not attempts[-1].disturbed
        assert attempts[-1].duration_s > 1.0


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
