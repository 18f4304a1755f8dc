"""The cells that run on this machine, as files in the user's runtime folder.

`run` puts one there and takes it away; one whose process is gone is taken away by whoever looks.
Two runs in one cell have a file each, so that the cell is known until the last of them has ended.
"""

import logging
import os
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

import msgspec
import platformdirs

from surefetch.common.errors import InfrastructureError

log = logging.getLogger(__name__)

FORMAT: Final = 1


class RunningCell(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One cell that a process of this machine has started or joined."""

    format: int = FORMAT
    name: str
    endpoints: tuple[str, ...]
    """Where its services are reached."""
    pid: int
    """The process that takes the file away."""
    started_s: float
    """Since 1970."""


def default_folder() -> Path:
    """The user's runtime folder; need not be there yet."""
    with warnings.catch_warnings():  # that there is no such folder, and which one is used instead
        warnings.simplefilter("ignore", UserWarning)
        return Path(platformdirs.user_runtime_dir("surefetch")) / "cells"


@contextmanager
def announced(cell: RunningCell, folder: Path | None = None) -> Iterator[None]:
    """Let `stop`, `status` and `watch` find the cell while the block runs.

    A folder that cannot be written is told in the log: the cell then needs ``--connect``.
    """
    path = (folder or default_folder()) / f"{cell.name}-{cell.pid}.json"
    try:
        _write(path, msgspec.json.encode(cell))
    except OSError as error:
        log.warning("%s: %s; stop, status and watch need --connect", path, error.strerror)
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink()


def running_cells(folder: Path | None = None) -> tuple[RunningCell, ...]:
    """The cells whose process is there, each once, newest first; files of others are removed."""
    cells: dict[str, RunningCell] = {}
    for path in (folder or default_folder()).glob("*.json"):
        cell = _read(path)
        if cell is None:
            continue
        if _is_there(cell.pid):
            known = cells.get(cell.name, cell)
            cells[cell.name] = max(known, cell, key=lambda one: one.started_s)
        else:
            with suppress(OSError):
                path.unlink()
    return tuple(sorted(cells.values(), key=lambda cell: cell.started_s, reverse=True))


def newest_cell(folder: Path | None = None) -> RunningCell:
    """The cell that was started last. Raises InfrastructureError if none runs."""
    cells = running_cells(folder)
    if not cells:
        raise InfrastructureError(NONE_RUNS)
    return cells[0]


NONE_RUNS: Final = (
    "no cell runs on this machine, as far as this user's `surefetch run` tells.\n"
    "  For another one, name an endpoint: --connect tcp/HOST:PORT"
)


def _write(path: Path, content: bytes) -> None:
    """The whole file or none."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    unfinished = path.with_suffix(f".{os.getpid()}.part")
    unfinished.write_bytes(content)
    unfinished.replace(path)


def _read(path: Path) -> RunningCell | None:
    """The cell in a file, or None with a word in the log: another version wrote it, or it went."""
    try:
        cell = msgspec.json.decode(path.read_bytes(), type=RunningCell)
    except (OSError, msgspec.MsgspecError) as error:
        log.warning("%s is not read: %s", path, error)
        return None
    return cell if cell.format == FORMAT else None


def _is_there(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return True
