"""A machine's file and the command line together, and every way in which they can be wrong."""

import re
from pathlib import Path

import pytest

from surefetch.common.cell import parse_cell, read_cell, simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.settings import read_machine, read_settings

ENDPOINTS = """
[endpoints]
executor = "tcp/192.0.2.10:7447"
perception = "tcp/192.0.2.20:7447"
belief = "tcp/192.0.2.30:7447"
planner = "tcp/192.0.2.30:7448"
"""


def written(folder: Path, text: str) -> str:
    path = folder / "machine.toml"
    path.write_text(text, "utf-8")
    return str(path)


def test_without_a_file_a_service_listens_on_a_free_loopback_port() -> None:
    settings = read_settings([], "belief")
    (endpoint,) = settings.bus.listen
    assert re.fullmatch(r"tcp/127\.0\.0\.1:\d+", endpoint)
    assert settings.bus.connect == ()
    assert settings.bus.cell == settings.cell.name == "sim"
    assert (settings.executor, settings.perception) == ("pybullet", "classical")


def test_a_file_makes_a_full_mesh(tmp_path: Path) -> None:
    settings = read_settings(["--config", written(tmp_path, ENDPOINTS)], "belief")
    assert settings.bus.listen == ("tcp/192.0.2.30:7447",)
    assert settings.bus.connect == (
        "tcp/192.0.2.10:7447",
        "tcp/192.0.2.20:7447",
        "tcp/192.0.2.30:7448",
    )


def test_the_command_line_wins_over_the_file(tmp_path: Path) -> None:
    text = 'name = "lab"\nlog_level = "error"\njournal_dir = "journals"\n' + ENDPOINTS
    path = written(tmp_path, text)
    from_file = read_settings(["--config", path], "planner")
    assert from_file.bus.cell == "lab"
    assert from_file.log_level == "error"
    assert from_file.journal_dir == tmp_path / "journals"
    words = ["--config", path, "--name", "x", "--log-level", "debug", "--journal-dir", "there"]
    words += ["--listen", "tcp/127.0.0.1:1", "--connect", "tcp/127.0.0.1:2", "--real-time"]
    told = read_settings(words, "planner")
    assert told.bus.cell == "x"
    assert told.bus.listen == ("tcp/127.0.0.1:1",)
    assert told.bus.connect == ("tcp/127.0.0.1:2",)
    assert (told.log_level, told.journal_dir, told.real_time) == ("debug", Path("there"), True)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "missing required field `endpoints`"),
        (ENDPOINTS.replace("belief", "beleif"), "unknown field `beleif`|field `belief`"),
        (ENDPOINTS.split("planner")[0], "field `planner`"),
        ('colour = "red"\n' + ENDPOINTS, "unknown field `colour`"),
        ("real_time = 1\n" + ENDPOINTS, r"Expected `bool`, got `int` - at `\$.real_time`"),
        ('perception = "vlm"\n' + ENDPOINTS, "Invalid enum value 'vlm'"),
        ("name = [", "machine.toml"),
        ('name = "a/b"\n' + ENDPOINTS, 'cannot be called "a/b"'),
        ('cell = "none.toml"\n' + ENDPOINTS, "none.toml cannot be read: No such file"),
    ],
)
def test_what_is_wrong_with_a_file_is_named(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(BadInput, match=words):
        read_settings(["--config", written(tmp_path, text)], "belief")


def test_a_file_that_is_not_there_or_no_text_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="none.toml cannot be read: No such file"):
        read_machine(tmp_path / "none.toml")
    path = tmp_path / "bytes.toml"
    path.write_bytes(b"\xff\xfe")
    for read in (read_machine, read_cell):
        with pytest.raises(BadInput, match=r"bytes\.toml"):
            read(path)


def test_an_option_of_the_wrong_kind_ends_with_status_2(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit) as ended:
        read_settings(["--log-level", "loud"], "belief")
    assert ended.value.code == 2
    assert "surefetch serve belief" in capsys.readouterr().err


def test_a_cell_names_what_it_lacks() -> None:
    cell = simulated_cell()
    assert [row.name for row in cell.informs] == ["right", "close_high", "remove_cover"]
    with pytest.raises(BadInput, match='no view "left".\n  Views: center, right, close_high'):
        cell.view("left")
    with pytest.raises(BadInput, match='no action "left"'):
        cell.inform("left")


def test_an_action_whose_view_is_not_there_is_refused() -> None:
    cell = simulated_cell()
    text = (Path(__file__).parents[3] / "common/src/surefetch/common/cells/sim.toml").read_text()
    assert parse_cell(text, "sim.toml") == cell
    with pytest.raises(BadInput, match='no view "above"'):
        parse_cell(text.replace('view = "close_high"', 'view = "above"'), "sim.toml")
    with pytest.raises(BadInput, match=r"sim\.toml.*missing required field `cost`"):
        parse_cell(text.replace("cost = 0.160\n", ""), "sim.toml")
