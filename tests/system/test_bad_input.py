"""What cannot be used ends in one clear sentence: exit 2, nothing moved, nothing half-written."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from surefetch.common import cli
from surefetch.common.journal import read_journal
from surefetch.common.launch import Launch, Services
from surefetch.common.topics import EXECUTE, EXECUTOR, PERCEPTION, SERVICES

pytestmark = pytest.mark.system


@pytest.fixture(scope="module")
def journals(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cell")


@pytest.fixture(scope="module")
def cell(journals: Path) -> Iterator[Services]:
    with Services.start(Launch(services=SERVICES, cell="bad-input", folder=journals)) as services:
        yield services


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in, and a runtime folder of its own."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "runtime"))
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "here"


@pytest.mark.parametrize(
    ("sentence", "said"),
    [
        ("the red blue cylinder", 'color "red" and "blue"'),
        ("the red cylinder inside outside the box", 'relation "inside" and "outside"'),
        ("the red unicorn", '"unicorn" is nothing that this perception'),
        ("the", "names no object"),
        (" ", "the instruction is empty"),
        ("the cylinder that is not red", "not"),
    ],
)
def test_a_sentence_that_cannot_be_meant_moves_nothing(
    sentence: str,
    said: str,
    cell: Services,
    journals: Path,
    here: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    words = ["run", sentence, "--scene", "covered:1", "--connect", cell.endpoints[0], "--json"]
    assert cli.main(words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert "Traceback" not in err
    assert list(here.iterdir()) == []
    (path,) = journals.glob(f"{EXECUTOR}-*.journal")
    assert EXECUTE.name not in [record.topic for record in read_journal(path).records]


def configuration(folder: Path, endpoints: dict[str, str]) -> Path:
    lines = [f'{service} = "{endpoint}"\n' for service, endpoint in endpoints.items()]
    path = folder.parent / "lab.toml"
    path.write_text("[endpoints]\n" + "".join(lines))
    return path


def test_an_endpoint_in_use_that_the_user_named_is_said(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        ports = {EXECUTOR: port, PERCEPTION: port - 1, "belief": port - 2, "planner": port - 3}
        config = configuration(here, {s: f"tcp/127.0.0.1:{p}" for s, p in ports.items()})
        assert cli.main(["run", "--scene", "covered:1", "--config", str(config)]) == 2
    err = capsys.readouterr().err
    assert f"tcp/127.0.0.1:{port}" in err and "Is another process listening there?" in err
    assert list(here.iterdir()) == []


def test_a_missing_key_of_the_configuration_is_named(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = configuration(here, {EXECUTOR: "tcp/127.0.0.1:7447"})
    assert cli.main(["run", "--scene", "covered:1", "--config", str(config)]) == 2
    assert "`perception`" in capsys.readouterr().err
    assert list(here.iterdir()) == []


def test_a_view_that_the_cell_has_not_is_named(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    endpoints = {service: f"tcp/127.0.0.1:{28700 + i}" for i, service in enumerate(SERVICES)}
    config = configuration(here, endpoints)
    shipped = Path(cli.__file__).parent / "cells" / "sim.toml"
    cell = shipped.read_text().replace('view = "close_high"', 'view = "below"')
    (config.parent / "cell.toml").write_text(cell)
    config.write_text('cell = "cell.toml"\n' + config.read_text())
    assert cli.main(["run", "--scene", "covered:1", "--config", str(config)]) == 2
    err = capsys.readouterr().err
    assert 'no view "below"' in err and "Views: center, right, close_high" in err
    assert list(here.iterdir()) == []


def test_an_endpoint_where_nothing_is_up_is_an_absent_cell(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
        assert cli.main(["run", "--scene", "covered:1", "--connect", endpoint]) == 3
    assert f"nothing is up at {endpoint}" in capsys.readouterr().err
    assert list(here.iterdir()) == []


def test_an_endpoint_that_is_none_is_bad_input(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["run", "--scene", "covered:1", "--connect", "kitchen"]) == 2
    assert "An endpoint looks like" in capsys.readouterr().err
    assert list(here.iterdir()) == []
