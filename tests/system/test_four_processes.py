"""Four processes that were up before: used by run, watch and client, and left as they were."""

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from rerun.chunk import RrdReader
from run_process import RunProcess

from surefetch.client import Cell
from surefetch.common import cli
from surefetch.common.launch import Launch, Services
from surefetch.common.messages import Ended
from surefetch.common.topics import EXECUTOR, LOAD_SCENE, PERCEPTION, SERVICES
from surefetch.evaluation.scenes.generate import generate

pytestmark = pytest.mark.system


@pytest.fixture(scope="module")
def services(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Services]:
    folder = tmp_path_factory.mktemp("cell")
    with Services.start(Launch(services=SERVICES, cell="lab", folder=folder)) as started:
        yield started


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_run_uses_what_is_up_while_another_program_watches(
    services: Services, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    endpoint = services.endpoints[0]
    watch = RunProcess(["watch", "--connect", endpoint, "--no-open", "--save", "seen.rrd"], here)
    try:
        watch.until("Ctrl-C ends watching")
        words = ["run", "--scene", "visible:0", "--connect", endpoint, "--out", "out", "--json"]
        status = cli.main(words)
        told = json.loads(capsys.readouterr().out.splitlines()[-1])
        watch.until("absent")
        os.kill(watch.process.pid, signal.SIGINT)
        assert watch.wait(10.0) == 0
    finally:
        watch.end()
    assert status == 0
    assert {name: s["pid"] for name, s in told["services"].items()} == services.pids
    assert services.died() == {}
    seen = {chunk.entity_path for chunk in RrdReader(here / "seen.rrd").stream()}
    assert {"/world/camera/image", "/world/arm/wrist_3", "/belief/absent"} <= seen


def test_a_program_of_the_users_own_fetches_in_a_cell_that_is_up(services: Services) -> None:
    scene = generate("visible", 0)
    with Cell(services.endpoints[0]) as cell:
        cell.bus.ask(LOAD_SCENE, scene.scene, timeout_s=30.0)
        events = list(cell.fetch(scene.sentence))
    assert [event.seq for event in events] == list(range(len(events)))
    assert isinstance(events[-1].happening, Ended)
    assert events[-1].happening.outcome in ("grasped", "deferred")


def test_a_run_starts_what_is_missing_and_ends_only_that(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    launch = Launch(services=(EXECUTOR, PERCEPTION), cell="half", folder=here / "half")
    with Services.start(launch) as half:
        words = ["run", "--scene", "visible:0", "--connect", half.endpoints[0], "--out", "out"]
        assert cli.main([*words, "--json"]) == 0
        told = json.loads(capsys.readouterr().out.splitlines()[-1])
        pids = {name: service["pid"] for name, service in told["services"].items()}
        assert half.pids.items() <= pids.items()
        assert set(pids) == set(SERVICES)
        assert half.died() == {}
    assert told["missing"] == []
