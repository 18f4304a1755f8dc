"""`stop`, `status` and `doctor` on cells of this machine, and how they find them."""

import json
import os
import subprocess
import sys
import time
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import pytest
from tiny_process import tiny_service

from surefetch.common import codec, running_cells
from surefetch.common.bus import Call
from surefetch.common.cli import main
from surefetch.common.launch import own_cell_name
from surefetch.common.messages import Stopped
from surefetch.common.running_cells import RunningCell, announced
from surefetch.common.settings import BusSettings, free_endpoint
from surefetch.common.topics import EXECUTOR, STOP
from surefetch.common.zenoh_bus import ZenohBus

pytestmark = pytest.mark.system


@pytest.fixture(autouse=True)
def runtime_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    return running_cells.default_folder()


def last_json(capsys: pytest.CaptureFixture[str]) -> Any:
    return json.loads(capsys.readouterr().out.splitlines()[-1])


def running_executor(stack: ExitStack, *, was_moving: bool) -> BusSettings:
    """A cell with an executor that is good for stopping, announced on this machine."""
    settings = BusSettings(own_cell_name(), listen=(free_endpoint(),))
    bus = stack.enter_context(closing(ZenohBus(settings, EXECUTOR)))

    def on_stop(call: Call) -> None:
        stopped = Stopped(was_moving=was_moving, took_s=0.25)
        call.reply(codec.encode(stopped, max_bytes=10_000))

    bus.answer(STOP, on_stop)
    bus.announce()
    announce(stack, settings.cell, settings.listen)
    return settings


def announce(stack: ExitStack, name: str, endpoints: tuple[str, ...]) -> None:
    cell = RunningCell(name=name, endpoints=endpoints, pid=os.getpid(), started_s=time.time())
    stack.enter_context(announced(cell))


def test_stop_stops_every_cell_of_this_machine(capsys: pytest.CaptureFixture[str]) -> None:
    with ExitStack() as stack:
        first = running_executor(stack, was_moving=True)
        second = running_executor(stack, was_moving=False)
        assert main(["stop"]) == 0
        said = capsys.readouterr().out
        assert f"{first.cell}: was moving, came to rest after 0.25 s" in said
        assert f"{second.cell}: was at rest" in said
        assert main(["stop", "--json"]) == 0
        stops = {one["cell"]: one["was_moving"] for one in last_json(capsys)["cells"]}
    assert stops == {first.cell: True, second.cell: False}


def test_a_cell_that_cannot_be_stopped_is_told_and_the_others_are_stopped(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with ExitStack() as stack:
        reached = running_executor(stack, was_moving=True)
        announce(stack, "gone", (free_endpoint(),))
        assert main(["stop"]) == 3
    said = capsys.readouterr().out
    assert "gone: NOT STOPPED. executor is not there" in said
    assert f"{reached.cell}: was moving" in said


def test_without_a_cell_stop_and_status_say_what_to_do(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for command in ("stop", "status"):
        assert main([command]) == 3
        said = capsys.readouterr().err
        assert "no cell runs on this machine" in said
        assert "--connect" in said


def test_status_shows_the_newest_cell_and_who_is_missing(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with tiny_service() as older, tiny_service() as newer, ExitStack() as stack:
        announce(stack, older.cell, (older.endpoint,))
        announce(stack, newer.cell, (newer.endpoint,))
        assert main(["status"]) == 0
        said = capsys.readouterr().out
        assert f"cell {newer.cell}\n" in said
        assert f"{newer.process.pid}" in said
        assert said.count("not up") == 3
        assert main(["status", "--connect", older.endpoint, "--json"]) == 0
        status = last_json(capsys)
    assert status["cell"] == older.cell
    assert status["services"]["planner"]["pid"] == older.process.pid
    assert status["services"]["planner"]["backend"] == "tiny"
    assert status["missing"] == ["executor", "perception", "belief"]


def test_nothing_at_an_endpoint_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    endpoint = free_endpoint()
    for command in ("stop", "status"):
        assert main([command, "--connect", endpoint]) == 3
        assert f"nothing is up at {endpoint}" in capsys.readouterr().err


def test_doctor_tells_what_works(capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["doctor", "--json"])
    told = last_json(capsys)
    findings = {one["what"]: one for one in told["findings"]}
    assert (status == 0) == told["ok"] == all(f["grade"] != "fails" for f in findings.values())
    assert findings["Python"]["grade"] == "works"
    assert findings["zenoh"]["grade"] == "works"
    assert findings["loopback"]["detail"].startswith("a question and its answer take")


def test_the_help_is_there_at_once_with_an_example_for_every_command() -> None:
    program = Path(sys.executable).with_name("surefetch")
    took_s = []
    for _ in range(3):
        start_s = time.monotonic()
        done = subprocess.run([program, "--help"], capture_output=True, text=True, check=True)
        took_s.append(time.monotonic() - start_s)
    assert min(took_s) < 1.0
    for (
        command
    ) in "run serve stop status watch doctor view replay perceive filter solve study".split():
        assert f"$ surefetch {command}" in done.stdout
