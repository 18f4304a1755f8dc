"""Cells that run on this machine are found, newest first; those whose process is gone are not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from surefetch.common.errors import InfrastructureError
from surefetch.common.running_cells import (
    RunningCell,
    announced,
    default_folder,
    newest_cell,
    running_cells,
)


def a_cell(name: str, started_s: float, pid: int | None = None) -> RunningCell:
    return RunningCell(
        name=name,
        endpoints=("tcp/127.0.0.1:7447", "tcp/127.0.0.1:7448"),
        pid=os.getpid() if pid is None else pid,
        started_s=started_s,
    )


def gone_pid() -> int:
    done = subprocess.Popen([sys.executable, "-c", ""])
    done.wait()
    return done.pid


def test_cells_are_found_while_they_run_the_newest_first(tmp_path: Path) -> None:
    folder = tmp_path / "cells"
    older, newer = a_cell("older", 10.0), a_cell("newer", 20.0)
    assert running_cells(folder) == ()
    with announced(newer, folder), announced(older, folder):
        assert running_cells(folder) == (newer, older)
        assert newest_cell(folder) == newer
    assert [*folder.iterdir()] == []


def test_a_cell_is_known_until_the_last_run_in_it_has_ended(tmp_path: Path) -> None:
    first, joined = a_cell("shared", 10.0), a_cell("shared", 20.0, os.getppid())
    with announced(first, tmp_path):
        with announced(joined, tmp_path):
            assert running_cells(tmp_path) == (joined,)
        assert running_cells(tmp_path) == (first,)


def test_a_cell_goes_however_its_run_ends(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), announced(a_cell("x", 1.0), tmp_path):
        raise KeyboardInterrupt
    assert running_cells(tmp_path) == ()


def test_a_cell_whose_process_is_gone_is_cleared_away(tmp_path: Path) -> None:
    with announced(a_cell("stale", 1.0, gone_pid()), tmp_path):
        assert len([*tmp_path.iterdir()]) == 1
        assert running_cells(tmp_path) == ()
        assert [*tmp_path.iterdir()] == []


def test_files_that_are_no_cells_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "half.json").write_bytes(b'{"format":1,"na')
    (tmp_path / "later.json").write_bytes(b'{"format":2,"more":1}')
    (tmp_path / "cell.123.part").write_bytes(b"{")
    cell = a_cell("whole", 1.0)
    with announced(cell, tmp_path):
        assert running_cells(tmp_path) == (cell,)
    assert len([*tmp_path.iterdir()]) == 3


def test_without_a_cell_the_user_is_told_what_to_name(tmp_path: Path) -> None:
    with pytest.raises(InfrastructureError, match="no cell runs on this machine"):
        newest_cell(tmp_path)


def test_a_folder_that_cannot_be_written_does_not_stop_the_run(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with announced(a_cell("x", 1.0), tmp_path / "file" / "cells"):
        pass


def test_the_folder_is_the_users_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    assert default_folder() == tmp_path / "surefetch" / "cells"
    monkeypatch.delenv("XDG_RUNTIME_DIR")
    assert default_folder().parts[-2:] == ("surefetch", "cells")  # and no warning, which fails
    with announced(a_cell("x", 1.0), tmp_path / "new"):
        assert (tmp_path / "new").stat().st_mode & 0o077 == 0
