"""A run's folder appears whole or not at all, and can be drawn again from its journal."""

import json
from pathlib import Path

import made_up_episode
import pytest

from surefetch.common.errors import BadInput, InfrastructureError
from surefetch.evaluation.running import artifacts
from surefetch.evaluation.showing import view
from surefetch.evaluation.showing.observed import Observed
from surefetch.evaluation.showing.observed_journal import OBSERVER, ObservedJournal, read_observed

TOLD = {"format": 1, "outcome": "grasped"}


def observer_journal(folder: Path) -> bytes:
    path = folder / "observer"
    seen = made_up_episode.observed()
    journal = ObservedJournal(path, "boot")
    for frame in seen.frames.values():
        journal.fetched(frame)
    for message in seen.log:
        journal.heard(message)
    journal.close()
    return path.read_bytes()


@pytest.fixture
def run(tmp_path: Path) -> Path:
    folder = tmp_path / "runs" / "one"
    journals = {OBSERVER: observer_journal(tmp_path), "planner": b"records"}
    artifacts.write(folder, TOLD, made_up_episode.observed(), journals)
    return folder


def test_a_run_leaves_what_is_promised(run: Path) -> None:
    names = {str(path.relative_to(run)) for path in run.rglob("*") if path.is_file()}
    assert names == {
        "summary.json",
        "trace.png",
        "episode.rrd",
        "journal/observer.journal",
        "journal/planner.journal",
    }
    assert json.loads((run / "summary.json").read_text()) == TOLD
    assert [path.name for path in run.parent.iterdir()] == ["one"]


def test_a_run_may_take_the_place_of_an_earlier_one(run: Path) -> None:
    (run / "notes.txt").write_text("of the earlier run")
    artifacts.check_free(run)
    artifacts.write(run, {**TOLD, "outcome": "deferred"}, made_up_episode.observed(), {})
    assert artifacts.read_summary(run)["outcome"] == "deferred"
    assert not (run / "notes.txt").exists()
    assert [path.name for path in run.parent.iterdir()] == ["one"]


def test_a_run_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="JSON"):
        artifacts.write(tmp_path / "one", {"q": float("nan")}, made_up_episode.observed(), {})
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_takes_nothing_is_said(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InfrastructureError, match="was not kept"):
        artifacts.write(tmp_path / "file" / "one", TOLD, made_up_episode.observed(), {})


def test_a_file_is_no_folder_for_a_run(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="is a file"):
        artifacts.check_free(tmp_path / "file")


def test_the_pictures_can_be_drawn_again(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    drawn = (run / "trace.png").read_bytes()
    (run / "episode.rrd").unlink()
    (run / "trace.png").unlink()
    assert view.main([str(run), "--no-open"]) == 0
    assert (run / "episode.rrd").stat().st_size > 1000
    assert (run / "trace.png").read_bytes() == drawn
    assert f"rerun {run / 'episode.rrd'}" in capsys.readouterr().out


def test_a_folder_without_a_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="holds no run"):
        view.main([str(tmp_path)])


def test_a_damaged_journal_is_refused(run: Path) -> None:
    artifacts.journal_path(run, OBSERVER).write_bytes(b"\x05\x00\x00\x00hello")
    with pytest.raises(BadInput, match="no journal"):
        view.main([str(run), "--rebuild", "--no-open"])


def test_a_torn_end_costs_the_last_record_only(run: Path) -> None:
    path = artifacts.journal_path(run, OBSERVER)
    path.write_bytes(path.read_bytes()[:-3])
    whole = made_up_episode.observed()
    assert read_observed(path).events == whole.events[:-1]


def test_an_episode_of_which_nothing_was_seen_can_be_written(tmp_path: Path) -> None:
    artifacts.write(tmp_path / "one", TOLD, Observed((), {}), {})
    assert (tmp_path / "one" / "trace.png").exists()
