"""A service that is killed in mid-episode ends the run soon, by name, with the arm at rest."""

import json
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from run_process import SERVICES, RunProcess, is_there

from surefetch.client import Cell
from surefetch.common.journal import read_journal
from surefetch.common.messages import Outcome, Stopped
from surefetch.common.running_cells import newest_cell
from surefetch.common.topics import EXECUTE, EXECUTOR, STOP
from surefetch.evaluation.showing.observed_journal import read_observed

pytestmark = pytest.mark.system

END_S = 5.0
BEGIN_S = 30.0
"""For the arm to have lifted the cover"""


@pytest.fixture
def run(tmp_path: Path) -> Iterator[RunProcess]:
    """An episode at the pace of a real arm, so that it can be killed in mid-motion."""
    words = ["run", "--scene", "covered:1", "--real-time", "--out", "out"]
    process = RunProcess(words, tmp_path)
    yield process
    process.end()


@pytest.mark.parametrize("service", SERVICES)
def test_a_killed_service_ends_the_run(service: str, run: RunProcess, tmp_path: Path) -> None:
    until_the_cover_is_carried(run, tmp_path)
    pids = run.pids()
    assert set(pids) == set(SERVICES)
    os.kill(pids[service], signal.SIGKILL)
    killed_s = time.monotonic()
    assert run.wait() == 3
    took_s = time.monotonic() - killed_s
    assert took_s < END_S
    assert f"{service} died in mid-episode (killed by signal 9)" in run.errors()
    assert not any(is_there(pid) for pid in pids.values())
    told = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (told["outcome"], told["correct"]) == ("aborted", False)
    assert service in told["because"]
    assert {path.name for path in tmp_path.iterdir()} == {"out", "runtime"}
    assert list((tmp_path / "runtime").rglob("*.json")) == []
    journals = tmp_path / "out" / "journal"
    assert {path.stem for path in journals.iterdir()} == {*SERVICES, "observer"}
    assert read_observed(journals / "observer.journal").accepted is not None
    if service != "executor":
        assert_came_to_rest(journals / "executor.journal")


def test_ctrl_c_stops_the_arm_and_keeps_what_was_seen(run: RunProcess, tmp_path: Path) -> None:
    until_the_cover_is_carried(run, tmp_path)
    pids = run.pids()
    os.kill(run.process.pid, signal.SIGINT)
    interrupted_s = time.monotonic()
    assert run.wait() == 1
    assert time.monotonic() - interrupted_s < END_S
    told = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (told["outcome"], told["correct"]) == ("stopped", False)
    assert not any(is_there(pid) for pid in pids.values())
    assert_came_to_rest(tmp_path / "out" / "journal" / "executor.journal")


def until_the_cover_is_carried(run: RunProcess, folder: Path) -> None:
    """The removal's longest motion has begun; it takes some five seconds."""
    run.until("understood")
    end_s = time.monotonic() + BEGIN_S
    running = newest_cell(folder / "runtime" / "surefetch" / "cells")
    with Cell(*running.endpoints) as cell:
        while doing(cell) != "carry":
            assert time.monotonic() < end_s, f"the cover was not carried:\n{run.text()}"
            time.sleep(0.05)


def doing(cell: Cell) -> str:
    """What the executor does now."""
    return next(status.doing for status in cell.status() if status.service == EXECUTOR)


def assert_came_to_rest(path: Path) -> None:
    """The motion under way was stopped, and its end is in the journal."""
    records = read_journal(path).records
    stops = [r.message(Stopped) for r in records if (r.kind, r.topic) == ("reply", STOP.name)]
    ends = [r.message(Outcome) for r in records if (r.kind, r.topic) == ("reply", EXECUTE.name)]
    asked = [r for r in records if (r.kind, r.topic) == ("request", EXECUTE.name)]
    assert [stop.was_moving for stop in stops] == [True]
    assert len(asked) == len(ends)
    *looks, removal = [end.status for end in ends]
    assert looks == ["done"] * len(looks)
    assert removal == "stopped"
