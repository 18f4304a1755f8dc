"""Recordings tell apart what they were made with, and nothing else."""

import sys
from collections.abc import Iterator
from importlib import invalidate_caches
from pathlib import Path

import pytest

from surefetch.common.cell import simulated_cell
from surefetch.evaluation.recordings import made_with

NAME = "made_up_sources"


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Path, Path]]:
    """Two places in which the same package may lie, the first of which counts."""
    first, second = tmp_path / "first", tmp_path / "second"
    for folder in (first, second):
        (folder / NAME).mkdir(parents=True)
    monkeypatch.syspath_prepend(second)
    monkeypatch.syspath_prepend(first)
    yield first / NAME, second / NAME
    forget()


def forget() -> None:
    for name in [name for name in sys.modules if name.startswith(NAME)]:
        del sys.modules[name]
    invalidate_caches()


def digest() -> str:
    forget()
    made_with._sources.cache_clear()
    return made_with._sources((NAME,))


def test_a_changed_and_a_renamed_source_make_another_digest(folders: tuple[Path, Path]) -> None:
    first, _ = folders
    (first / "part.py").write_text("x = 1")
    before = digest()
    (first / "part.py").write_text("x = 2")
    changed = digest()
    (first / "part.py").rename(first / "other.py")
    assert len({before, changed, digest()}) == 3


def test_a_second_copy_that_is_never_imported_changes_nothing(folders: tuple[Path, Path]) -> None:
    first, second = folders
    (first / "part.py").write_text("x = 1")
    before = digest()
    (second / "part.py").write_text("x = 2")
    assert digest() == before


def test_everything_that_is_named_can_be_found() -> None:
    made = made_with.made_with(simulated_cell(), "classical-1")
    assert len({made.generator, made.perception, made.planning, made.cell_file}) == 4
