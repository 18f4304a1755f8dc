"""What recordings are made with, named so that two that differ in it can be told apart."""

import hashlib
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Final

import msgspec

from surefetch.common.cell import Cell
from surefetch.evaluation.recordings.recording import MadeWith
from surefetch.evaluation.scenes.candidate import GENERATOR_VERSION

GENERATOR: Final = ("surefetch.evaluation.scenes", "surefetch.executor.simulation")
"""Sources that decide what a seed's scene is and how it looks."""
PERCEPTION: Final = ("surefetch.perception",)
PLANNING: Final = tuple(
    f"surefetch.executor.{part}" for part in ("robot", "motion", "grasping", "skills")
)
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
def _sources(packages: tuple[str, ...]) -> str:
    """One digest of all modules of some packages, by name and content."""
    parts = []
    for package in packages:
        for folder in map(Path, import_module(package).__path__):
            for path in sorted(folder.rglob("*.py")):
                parts += [str(path.relative_to(folder)).encode(), path.read_bytes()]
    return _digest(parts)


def _digest(parts: list[bytes]) -> str:
    whole = hashlib.sha256()
    for part in parts:
        whole.update(hashlib.sha256(part).digest())
    return whole.hexdigest()[:DIGITS]
