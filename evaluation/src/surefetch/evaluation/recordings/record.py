"""`surefetch study record`: many scenes to recordings, once; what is there is not made again."""

import argparse
import multiprocessing
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import cv2
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from surefetch.common.cell import simulated_cell
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.recordings.recording import FORMAT
from surefetch.evaluation.recordings.studio import Studio
from surefetch.evaluation.scenes.candidate import GENERATOR_VERSION
from surefetch.evaluation.scenes.generate import generate
from surefetch.perception.backends import BACKENDS
from surefetch.perception.frame_geometry import LatestGeometry

MOST_JOBS: Final = 2
ONE_THREAD: Final = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")


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
    jobs = [
        Job(asked.out, asked.perception, family, seed)
        for seed in seeds
        for family in families
        if not recording_store.is_recorded(asked.out, family, seed)
    ]
    wanted = len(seeds) * len(families)
    _record_all(jobs, asked.jobs, wanted)
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
    parser.add_argument("--jobs", type=int, choices=range(1, MOST_JOBS + 1), default=1)
    return parser


def _made_with(backend: str) -> dict[str, object]:
    return {
        "format": FORMAT,
        "generator_version": GENERATOR_VERSION,
        "cell": simulated_cell().name,
        "backend": BACKENDS[backend](LatestGeometry()).name,
    }


def record_one(job: Job) -> str:
    """Generate, record and save one scene; its address."""
    cv2.setNumThreads(1)
    made = generate(job.family, job.seed)
    with Studio(made, simulated_cell(), job.backend) as studio:
        recording, truth = studio.record()
    recording_store.save(job.folder, recording, truth, made.truth)
    return f"{job.family}:{job.seed}"


def _record_all(jobs: list[Job], workers: int, wanted: int) -> None:
    with Progress(
        TextColumn("recording"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.description}"),
        console=Console(stderr=True),
        disable=not sys.stderr.isatty(),
    ) as progress:
        task = progress.add_task("", total=wanted, completed=wanted - len(jobs))
        for done in _recorded(jobs, workers):
            progress.update(task, advance=1, description=done)


def _recorded(jobs: list[Job], workers: int) -> Iterator[str]:
    if workers == 1:
        yield from map(record_one, jobs)
        return
    for name in ONE_THREAD:
        os.environ.setdefault(name, "1")
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=fresh) as pool:
        running = [pool.submit(record_one, job) for job in jobs]
        try:
            for one in as_completed(running):
                yield one.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
