"""What recordings are made with, named so that two that differ in it can be told apart."""

import hashlib
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from types import ModuleType
from typing import Final

import msgspec

from surefetch.common.cell import Cell
from surefetch.evaluation.recordings.recording import MadeWith
from surefetch.evaluation.scenes.candidate import GENERATOR_VERSION

GENERATOR: Final = ("surefetch.evaluation.scenes", "surefetch.executor.simulation")
"""Sources that decide what a seed's scene is and how it looks."""
PERCEPTION: Final = ("surefetch.perception",)
PLANNING: Final = (
    *(f"surefetch.executor.{part}" for part in ("robot", "motion", "grasping", "skills")),
    "surefetch.executor.feasibility",
    "surefetch.belief.association",
    "surefetch.belief.tracking",
    "surefetch.planner.estimate",
    "surefetch.planner.looks",
    "surefetch.evaluation.recordings.histories",
    "surefetch.evaluation.recordings.prospects",
)
"""Sources that decide what the robot could do after which looks: packages and modules."""
DIGITS: Final = 16


def made_with(cell: Cell, backend: str) -> MadeWith:
    """What this installation would record with.

    Args:
        cell: whose views are taken.
        backend: the identity of the perception that answers.
    """
    return MadeWith(
        surefetch=version("surefetch-evaluation"),
        generator_version=GENERATOR_VERSION,
        generator=_sources(GENERATOR),
        cell=cell.name,
        cell_file=_digest([msgspec.json.encode(cell)]),
        backend=backend,
        perception=_sources(PERCEPTION),
        planning=_sources(PLANNING),
    )


@cache
def _sources(names: tuple[str, ...]) -> str:
    """One digest of some modules, and of all modules of some packages, by name and content."""
    parts = []
    for name in names:
        for path, said in _files(import_module(name)):
            parts += [said.encode(), path.read_bytes()]
    return _digest(parts)


def _files(module: ModuleType) -> Iterator[tuple[Path, str]]:
    """A module's file, or all files of a package, each with its name within it.

    Where a package lies in several folders, the first that has a file is the one imported.
    """
    if not hasattr(module, "__path__"):
        path = Path(str(module.__file__))
        yield path, path.name
        return
    found: dict[str, Path] = {}
    for folder in map(Path, module.__path__):
        for path in folder.rglob("*.py"):
            found.setdefault(str(path.relative_to(folder)), path)
    yield from ((path, name) for name, path in sorted(found.items()))


def _digest(parts: list[bytes]) -> str:
    whole = hashlib.sha256()
    for part in parts:
        whole.update(hashlib.sha256(part).digest())
    return whole.hexdigest()[:DIGITS]
