"""Units of work that may kill the worker that does them. Workers import this by name."""

import os
import signal
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Unit:
    """One."""

    folder: Path
    name: str
    dies: int = 0
    """How many of its workers are killed in the middle of it."""


def done(unit: Unit) -> bool:
    """Whether it was done."""
    return (unit.folder / unit.name).exists()


def work(unit: Unit) -> str:
    """Do it, unless it is to die first."""
    deaths = unit.folder / f"{unit.name}.deaths"
    so_far = len(deaths.read_text()) if deaths.exists() else 0
    if so_far < unit.dies:
        deaths.write_text("+" * (so_far + 1))
        os.kill(os.getpid(), signal.SIGKILL)
    (unit.folder / unit.name).write_text("done")
    return unit.name
