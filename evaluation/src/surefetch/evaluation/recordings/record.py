"""`surefetch study record`: many scenes to recordings, once; what is there is not made again."""

import argparse
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import msgspec
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from surefetch.common.cell import simulated_cell
from surefetch.evaluation.recordings import recording_store, splits, spread
from surefetch.evaluation.recordings.made_with import made_with
from surefetch.evaluation.recordings.recording import FORMAT
from surefetch.evaluation.recordings.studio import Studio
from surefetch.evaluation.scenes.generate import generate
from surefetch.perception.backends import BACKENDS
from surefetch.perception.frame_geometry import LatestGeometry


@dataclass(frozen=True)
class Job:
    """One scene to record."""

    folder: Path
    backend: str
    family: str
    seed: int


def main(argv: list[str]) -> int:
    """Record what is missing; Ctrl-C loses no finished scene."""
    asked = _parser().parse_args(argv)
    seeds = splits.seeds_of(asked.split, asked.episodes, asked.seeds)
    families = splits.families_of(asked.families)
    recording_store.write_manifest(asked.out, _made_with(asked.perception))
    folder = asked.out.resolve()
    jobs = [
        Job(folder, asked.perception, family, seed)
        for seed in seeds
        for family in families
        if not recording_store.is_recorded(folder, family, seed)
    ]
    wanted = len(seeds) * len(families)
    recorded = (
        spread.over_cores(record_one, jobs, asked.jobs, _is_done)
        if asked.ray is None
        else spread.over_ray(record_one, jobs, asked.ray)
    )
    _show(recorded, wanted - len(jobs), wanted)
    print(f"{wanted} scenes are recorded in {asked.out}; {len(jobs)} of them now.")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch study record",
        description="Generate scenes, and capture and perceive every view with the cover on and "
        "off, once. Scenes that are recorded already are left alone.",
        epilog="example: surefetch study record --split development --episodes 40 --out dev",
    )
    parser.add_argument("--split", metavar="S", help=", ".join(splits.SPLITS))
    parser.add_argument("--episodes", type=int, metavar="N", help="of each family")
    parser.add_argument("--seeds", metavar="A:B", help="instead: seeds A … B-1 of each family")
    parser.add_argument("--families", metavar="F,…", help="default: all five")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--perception", choices=sorted(BACKENDS), default="classical")
    cores = os.cpu_count() or 1
    parser.add_argument(
        "--jobs",
        type=int,
        choices=range(1, cores + 1),
        default=1,
        metavar="N",
        help=f"processes, at most {cores} here",
    )
    parser.add_argument(
        "--ray", metavar="ADDRESS", help="instead: a Ray cluster that shares the folder, or local"
    )
    return parser


def _made_with(backend: str) -> dict[str, object]:
    made = made_with(simulated_cell(), BACKENDS[backend](LatestGeometry()).name)
    return {"format": FORMAT, **msgspec.structs.asdict(made)}


def record_one(job: Job) -> str:
    """Generate, record and save one scene; its address."""
    cv2.setNumThreads(1)
    made = generate(job.family, job.seed)
    with Studio(made, simulated_cell(), job.backend) as studio:
        recording, truth = studio.record()
    recording_store.save(job.folder, recording, truth, made.truth)
    return f"{job.family}:{job.seed}"


def _is_done(job: Job) -> bool:
    return recording_store.is_recorded(job.folder, job.family, job.seed)


def _show(recorded: Iterator[str], before: int, wanted: int) -> None:
    with Progress(
        TextColumn("recording"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.description}"),
        console=Console(stderr=True),
        disable=not sys.stderr.isatty(),
    ) as progress:
        task = progress.add_task("", total=wanted, completed=before)
        for done in recorded:
            progress.update(task, advance=1, description=done)
