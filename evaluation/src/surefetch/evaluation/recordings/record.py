"""`surefetch study record`: many scenes to recordings, once; what is there is not made again."""

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import msgspec
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from surefetch.common.cell import simulated_cell
from surefetch.evaluation.recordings import recording_store, repeats, splits, spread
from surefetch.evaluation.recordings.made_with import made_with
from surefetch.evaluation.recordings.recording import FORMAT, Repeated
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


@dataclass(frozen=True)
class Done:
    """What is told of a recorded scene."""

    address: str
    spent_s: dict[str, float]
    """Processor time, by what was done."""
    repeated: Repeated | None


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
    done = _watched(recorded, wanted - len(jobs), wanted)
    print(f"{wanted} scenes are recorded in {asked.out}; {len(jobs)} of them now.")
    if done:
        print(_told(done))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch study record",
        description="Generate scenes, capture and perceive every view with the cover on and off, "
        "once, and ask the executor's planning what the robot could do after every order of looks. "
        "Scenes that are recorded already are left alone; an interrupted command is run again. "
        "Two scenes of a hundred are looked at twice: where more than one candidate of 200 is then "
        "put in another category, recording stops. What comes of removing covers and grasping is "
        "measured afterwards, by study measure.",
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


def record_one(job: Job) -> Done:
    """Generate, record and save one scene."""
    cv2.setNumThreads(1)
    began_s = time.process_time()
    made = generate(job.family, job.seed)
    generated_s = time.process_time() - began_s
    with Studio(made, simulated_cell(), job.backend) as studio:
        recorded = studio.record()
    recording = recorded.recording
    if repeats.is_repeated(job.family, job.seed):
        with Studio(made, simulated_cell(), job.backend) as studio:
            repeated = repeats.compared(recording.shots, studio.shots())
        recording = msgspec.structs.replace(recording, repeated=repeated)
    spent_s = {"generation": generated_s, **recording.durations_s}
    spent_s["everything else"] = time.process_time() - began_s - sum(spent_s.values())
    recording = msgspec.structs.replace(recording, durations_s=spent_s)
    recording_store.save_pictures(job.folder, recorded.pictures)
    recording_store.save(job.folder, recording, recorded.truth, made.truth)
    return Done(f"{job.family}:{job.seed}", spent_s, recording.repeated)


def _is_done(job: Job) -> bool:
    return recording_store.is_recorded(job.folder, job.family, job.seed)


def _watched(recorded: Iterator[Done], before: int, wanted: int) -> list[Done]:
    """All of them, with a bar; ends early where a second look does not show the same.

    Raises:
        InfrastructureError: recording the same scene again gives something else.
    """
    done: list[Done] = []
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
        for one in recorded:
            done.append(one)
            repeats.check(d.repeated for d in done if d.repeated is not None)
            progress.update(task, advance=1, description=one.address)
    return done


def _told(done: Sequence[Done]) -> str:
    """Where the time went, and whether second looks showed the same."""
    total = Counter[str]()
    for one in done:
        total.update(one.spent_s)
    each = ", ".join(f"{what} {s / len(done):.2f}" for what, s in total.most_common())
    twice = [one.repeated for one in done if one.repeated is not None]
    found = repeats.check(twice)
    return (
        f"Processor time of a scene: {total.total() / len(done):.2f} s ({each}).\n"
        f"{len(twice)} scenes were looked at twice: {found.differing} of {found.candidates} "
        "candidates were put in another category."
    )
