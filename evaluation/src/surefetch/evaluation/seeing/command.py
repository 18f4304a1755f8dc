"""`surefetch study perception`: what perception finds and answers, in pictures made for it."""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final

import cv2
from rich.console import Console
from rich.progress import track

from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.errors import BadInput
from surefetch.evaluation.recordings import splits
from surefetch.evaluation.scenes.generate import generate
from surefetch.evaluation.seeing import printing as perception_print
from surefetch.evaluation.seeing.conditions import unseen, unseen_camera
from surefetch.evaluation.seeing.images import Picture, cameras, pictures
from surefetch.evaluation.seeing.metrics import Scored
from surefetch.evaluation.seeing.scoring import scored
from surefetch.perception.backends import BACKENDS
from surefetch.perception.frame_geometry import LatestGeometry

SCENES: Final = 10
"""Of each family, for each of the two sets"""
UNSEEN_OFFSET: Final = 100


@dataclass(frozen=True)
class Wanted:
    """One scene and what to take of it."""

    family: str
    seed: int
    unseen: bool


def main(argv: list[str]) -> int:
    """Take the pictures, perceive them, print the table."""
    asked = _parser().parse_args(argv)
    figures_of = _figures()
    cv2.setNumThreads(1)
    first = splits.SPLITS[asked.split].start
    usual, strange = (
        _scored(_wanted(first, asked.scenes, new), asked.perception) for new in (False, True)
    )
    tables = {
        "usual": figures_of(usual),
        "unseen conditions": figures_of(strange),
    }
    told = {"backend": BACKENDS[asked.perception](LatestGeometry()).name, "seeds_from": first}
    if asked.out is not None:
        asked.out.mkdir(parents=True, exist_ok=True)
        (asked.out / "perception.json").write_text(
            json.dumps(told | tables, indent=1) + "\n", encoding="utf-8"
        )
    if asked.json:
        print(json.dumps(told | tables))
    else:
        perception_print.show(tables, Console())
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch study perception",
        description="Perceive pictures of generated scenes, three views each, the cover off, and "
        "pictures under lights, on tables and through lenses that the generator never draws, one "
        "view each. Figures come with 95 % intervals from resampled layouts. Ten scenes a family "
        "make 150 and 50 pictures.",
        epilog="example: surefetch study perception --out perception --json",
    )
    parser.add_argument("--scenes", type=int, default=SCENES, metavar="N", help="of each family")
    parser.add_argument(
        "--split",
        choices=("perception", "development"),
        default="perception",
        help="development: for choosing thresholds",
    )
    parser.add_argument("--perception", choices=sorted(BACKENDS), default="classical")
    parser.add_argument("--out", type=Path, metavar="DIR", help="also write DIR/perception.json")
    parser.add_argument("--json", action="store_true")
    return parser


def _figures() -> Any:
    """`figures.figures`, or what to install for it; before anything is rendered."""
    try:
        return import_module("surefetch.evaluation.seeing.figures").figures
    except ModuleNotFoundError as error:
        if error.name != "pycocotools":
            raise
        raise BadInput(
            "mask AP needs pycocotools, which is not installed.\n"
            '  Install it: pip install "./evaluation[coco]"'
        ) from None


def _wanted(first: int, scenes: int, new: bool) -> list[Wanted]:
    if not 0 < scenes <= UNSEEN_OFFSET:
        raise BadInput(f"--scenes must be between 1 and {UNSEEN_OFFSET}; found {scenes}.")
    start = first + (UNSEEN_OFFSET if new else 0)
    return [
        Wanted(family, seed, new)
        for seed in range(start, start + scenes)
        for family in splits.FAMILIES
    ]


def _scored(wanted: Sequence[Wanted], backend_name: str) -> list[Scored]:
    cell, geometry = simulated_cell(), LatestGeometry()
    backend = BACKENDS[backend_name](geometry)
    found = []
    for one in track(
        wanted,
        "unseen conditions" if wanted[0].unseen else "perceiving",
        console=Console(stderr=True),
        transient=True,
        disable=not sys.stderr.isatty(),
    ):
        for picture in _taken(one, cell):
            found.append(scored(picture, backend, geometry))
    return found


def _taken(one: Wanted, cell: Cell) -> Iterator[Picture]:
    made = generate(one.family, one.seed)
    if not one.unseen:
        yield from pictures(made, cell, made.scene, cameras(cell, made.scene))
        return
    turn = one.seed + splits.FAMILIES.index(one.family)
    camera = unseen_camera(made.scene, cell.views[turn % len(cell.views)])
    yield from pictures(made, cell, unseen(made.scene), (camera,))
