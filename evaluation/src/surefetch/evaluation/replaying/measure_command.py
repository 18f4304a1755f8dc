"""`surefetch study measure`: removals and grasps by physics, once; what is there is not redone."""

import argparse
import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
from rich.console import Console
from rich.progress import track

from surefetch.common.cell import simulated_cell
from surefetch.common.parameters import shipped_parameters
from surefetch.common.policies import DEFAULT_PROFILE
from surefetch.evaluation.recordings import recording_store, spread
from surefetch.evaluation.replaying.measure import measure


@dataclass(frozen=True)
class Job:
    """One recorded scene."""

    folder: Path
    family: str
    seed: int


def main(argv: list[str]) -> int:
    """Measure what was not measured yet; Ctrl-C loses no finished scene."""
    asked = _parser().parse_args(argv)
    folder = asked.recordings.resolve()
    every = [Job(folder, family, seed) for family, seed in recording_store.scenes(folder)]
    left = [job for job in every if not _is_done(job)]
    _measure(left, asked.jobs)
    print(f"{len(every)} scenes of {folder.name} are measured; {len(left)} of them now.")
    return 0


def _measure(jobs: Sequence[Job], cores: int) -> None:
    console = Console(stderr=True)
    running = spread.over_cores(measure_one, jobs, cores, _is_done)
    done = track(running, "measuring", len(jobs), console=console, disable=not sys.stderr.isatty())
    for _ in done:
        pass


def measure_one(job: Job) -> str:
    """Try, and keep what came of it; the scene's address."""
    cv2.setNumThreads(1)
    recording = recording_store.load(job.folder, job.family, job.seed)
    truth = recording_store.load_truth(job.folder, job.family, job.seed)
    numbers = shipped_parameters(DEFAULT_PROFILE)
    recording_store.save_measured(job.folder, measure(recording, truth, simulated_cell(), numbers))
    return f"{job.family}:{job.seed}"


def _is_done(job: Job) -> bool:
    return recording_store.is_measured(job.folder, job.family, job.seed)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch study measure",
        description="For every recorded scene, let the robot remove the cover and grasp the target "
        "in the simulator, and keep what came of it for `study evaluate --outcomes measured`.",
        epilog="example: surefetch study measure --recordings evaluation --jobs 2",
    )
    parser.add_argument("--recordings", type=Path, required=True, metavar="DIR")
    cores = os.cpu_count() or 1
    parser.add_argument(
        "--jobs", type=int, choices=range(1, cores + 1), default=1, metavar="N",
        help=f"processes, at most {cores} here",
    )  # fmt: skip
    return parser
