"""Starting the real services as processes, and leaving none behind."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path

import pytest

from surefetch.client import Cell
from surefetch.common import launch
from surefetch.common.errors import BadInput, InfrastructureError
from surefetch.common.journal import read_journal
from surefetch.common.launch import Launch, Services, own_cell_name
from surefetch.common.settings import BusSettings, free_endpoint
from surefetch.common.topics import BELIEF, PLANNER, SERVICES
from surefetch.common.zenoh_bus import ZenohBus

pytestmark = pytest.mark.system

LIGHT = (BELIEF, PLANNER)


def a_launch(folder: Path, services: tuple[str, ...] = LIGHT, **more: object) -> Launch:
    return Launch(services, own_cell_name(), folder, **more)  # type: ignore[arg-type]


@pytest.fixture
def used_endpoint() -> Iterator[str]:
    endpoint = free_endpoint()
    with closing(ZenohBus(BusSettings("other", listen=(endpoint,)))):
        yield endpoint


def all_gone(pids: Iterable[int], within_s: float) -> bool:
    deadline_s = time.monotonic() + within_s
    while any(map(is_there, pids)):
        if time.monotonic() > deadline_s:
            return False
        time.sleep(0.02)
    return True


def is_there(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_all_four_start_can_be_told_apart_and_end_together(tmp_path: Path) -> None:
    with Services.start(a_launch(tmp_path, SERVICES)) as services:
        for service, pid in services.pids.items():
            words = Path(f"/proc/{pid}/cmdline").read_bytes().decode().split("\0")
            assert words[1].endswith("surefetch")
            assert words[2:4] == ["serve", service]
        for endpoint in services.endpoints:
            with Cell(endpoint) as cell:
                assert [status.service for status in cell.status()] == [*SERVICES]
        assert services.died() == {}
        start_s = time.monotonic()
    assert time.monotonic() - start_s < 3.5
    assert services.died() == dict.fromkeys(SERVICES, 0)
    for service in SERVICES:
        (journal,) = tmp_path.glob(f"{service}-*.journal")
        assert read_journal(journal).header.service == service


def test_a_killed_service_is_told_by_its_name_and_the_rest_ends(tmp_path: Path) -> None:
    with Services.start(a_launch(tmp_path)) as services:
        os.kill(services.pids[BELIEF], signal.SIGKILL)
        deadline_s = time.monotonic() + 2.0
        while not services.died() and time.monotonic() < deadline_s:
            time.sleep(0.01)
        assert services.died() == {BELIEF: -signal.SIGKILL}
    assert all_gone(services.pids.values(), 0.0)


def test_services_end_when_whoever_started_them_is_killed(tmp_path: Path) -> None:
    program = (
        "import time\n"
        "from pathlib import Path\n"
        "from surefetch.common.launch import Launch, Services\n"
        f"launch = Launch({LIGHT!r}, {own_cell_name()!r}, Path({str(tmp_path)!r}))\n"
        "with Services.start(launch) as services:\n"
        "    print(*services.pids.values(), flush=True)\n"
        "    time.sleep(60)\n"
    )
    starter = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert starter.stdout is not None
    pids = [int(word) for word in starter.stdout.readline().split()]
    assert len(pids) == len(LIGHT)
    starter.kill()
    starter.communicate()
    assert all_gone(pids, within_s=3.0)


def test_a_stopped_service_is_killed_in_the_end(tmp_path: Path) -> None:
    services = Services.start(a_launch(tmp_path, (BELIEF,)))
    os.kill(services.pids[BELIEF], signal.SIGSTOP)
    services.close()
    assert services.died() == {BELIEF: -signal.SIGKILL}


def test_an_endpoint_in_use_that_the_user_named_is_bad_input(
    tmp_path: Path, used_endpoint: str
) -> None:
    endpoints = {BELIEF: free_endpoint(), PLANNER: used_endpoint}
    with pytest.raises(BadInput, match="^planner: these endpoints cannot be used") as met:
        Services.start(a_launch(tmp_path, endpoints=endpoints))
    assert f"cannot be used: --listen {used_endpoint}" in str(met.value)
    assert "Traceback" not in str(met.value)


def test_a_port_that_somebody_took_meanwhile_is_replaced_by_another(
    tmp_path: Path, used_endpoint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    choices = [{BELIEF: used_endpoint}, {BELIEF: free_endpoint()}]
    monkeypatch.setattr(launch, "_free_endpoints", lambda _: choices.pop(0))
    with Services.start(a_launch(tmp_path, (BELIEF,))) as services:
        assert services.endpoints != (used_endpoint,)
    assert choices == []


def test_what_a_service_refuses_is_told_in_its_own_words(tmp_path: Path) -> None:
    options = ("--config", str(tmp_path / "none.toml"))
    with pytest.raises(BadInput, match=r"none\.toml cannot be read: No such file"):
        Services.start(a_launch(tmp_path, options=options))


def test_a_service_that_is_not_ready_in_time_is_named_and_none_is_left(tmp_path: Path) -> None:
    with pytest.raises(InfrastructureError, match="belief was not ready within 0 s"):
        Services.start(a_launch(tmp_path), ready_s=0.0)
    assert [*processes_that_name(str(tmp_path))] == []


def processes_that_name(word: str) -> Iterator[int]:
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if word.encode() in path.read_bytes().split(b"\0"):
                yield int(path.parent.name)
        except OSError:
            continue  # it ended while it was looked at
