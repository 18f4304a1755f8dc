"""What a run leaves in its folder: written whole or not at all, and read back.

``summary.json`` (the JSON of `surefetch run`), ``journal/`` (one journal per service and the
observer's own, which holds the frames), ``episode.rrd`` (Rerun) and ``trace.png``.
"""

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from surefetch.common.errors import BadInput, InfrastructureError
from surefetch.evaluation.running import summary
from surefetch.evaluation.showing import recording_view, trace_figure
from surefetch.evaluation.showing.observed import Observed
from surefetch.evaluation.showing.observed_journal import OBSERVER, read_observed

SUMMARY: Final = "summary.json"
JOURNALS: Final = "journal"
RECORDING: Final = "episode.rrd"
TRACE: Final = "trace.png"


def check_free(folder: Path) -> None:
    """Refuse a folder that holds something else than an earlier run, which may be replaced.

    Raises:
        BadInput: the folder is in use, or cannot be made.
    """
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"--out {folder} is a file. Name a folder.")
    if folder.is_dir() and any(folder.iterdir()) and not _is_run(folder):
        raise BadInput(
            f"--out {folder} holds other files, which a run would replace. Name another folder."
        )
    above = next(parent for parent in folder.absolute().parents if parent.exists())
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise BadInput(f"--out {folder} cannot be made: {above} cannot be written to.")


def write(
    folder: Path, told: Mapping[str, Any], observed: Observed, journals: Mapping[str, bytes]
) -> None:
    """Write a run's folder; it appears complete, in place of an earlier run.

    Args:
        folder: not there yet, or a run (`check_free`).
        told: the summary.
        observed: for the pictures.
        journals: contents by service, and `OBSERVER`'s.

    Raises:
        InfrastructureError: the disk does not take it; nothing is left.
    """
    partial = folder.parent / f".{folder.name}.{os.getpid()}"
    try:
        (partial / JOURNALS).mkdir(parents=True)
        for name, content in journals.items():
            (partial / JOURNALS / f"{name}.journal").write_bytes(content)
        trace_figure.draw(observed, partial / TRACE)
        recording_view.write(observed, partial / RECORDING)
        text = json.dumps(told, indent=1, allow_nan=False, ensure_ascii=False)
        (partial / SUMMARY).write_text(text + "\n", encoding="utf-8")
        _replace(partial, folder)
    except OSError as error:
        raise InfrastructureError(
            f"the run was not kept: {folder} cannot be written: {error.strerror}"
        ) from None
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def read_summary(folder: Path) -> dict[str, Any]:
    """The summary of a run. Raises BadInput when the folder is none."""
    path = folder / SUMMARY
    try:
        told: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BadInput(
            f"{folder} holds no run: there is no {SUMMARY} in it.\n"
            f"  Make one: surefetch run --scene covered:1 --out DIR"
        ) from None
    except (OSError, ValueError) as error:
        raise BadInput(f"{path} cannot be read: {error}") from None
    if not isinstance(told, dict) or told.get("format") != summary.FORMAT:
        raise BadInput(f"{path} is no summary that this version reads.")
    return told


def journal_path(folder: Path, name: str) -> Path:
    """Where a run keeps the journal of a service, or of the observer."""
    return folder / JOURNALS / f"{name}.journal"


def rebuild(folder: Path) -> Path:
    """Draw the recording and the trace of a run again from its journal; the recording's path.

    Raises:
        BadInput: the folder is no run, or its journal cannot be read.
    """
    read_summary(folder)
    observed = read_observed(journal_path(folder, OBSERVER))
    trace_figure.draw(observed, folder / TRACE)
    recording_view.write(observed, folder / RECORDING)
    return folder / RECORDING


def _is_run(folder: Path) -> bool:
    try:
        read_summary(folder)
    except BadInput:
        return False
    return True


def _replace(partial: Path, folder: Path) -> None:
    """Put the new folder where the old one was, which goes last."""
    old = folder.parent / f".{folder.name}.{os.getpid()}.old"
    if folder.exists():
        folder.rename(old)
    partial.rename(folder)
    shutil.rmtree(old, ignore_errors=True)
