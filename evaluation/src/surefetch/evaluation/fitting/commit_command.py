"""`surefetch study commit`: how sure a grasp must be, by replaying the policy on development."""

import argparse
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

import msgspec
from rich.console import Console
from rich.progress import track
from rich.table import Table

from surefetch.common.cell import simulated_cell
from surefetch.common.parameters import PROFILES, profile_parameters, write_parameters
from surefetch.common.policies import OWN_PROFILE
from surefetch.evaluation.fitting.commit_threshold import AT_MOST, DELTA, GRID, Tried, lowest_safe
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.replaying.contenders import Contender, contender
from surefetch.evaluation.replaying.evaluate import Conditions, evaluate
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import ready

POLICY: Final = "ours"


def main(argv: list[str]) -> int:
    """Choose the threshold of profile extended and write it into its file."""
    parser = argparse.ArgumentParser(
        prog="surefetch study commit",
        description=f"Replay {POLICY} on development recordings with a grid of least beliefs for a "
        f"grasp, and keep the lowest under which wrong grasps stay below {AT_MOST:.0%} of the "
        f"episodes with {1 - DELTA:.0%} confidence; rewrites FOLDER/extended.json, which must be "
        "calibrated.",
        epilog="example: surefetch study commit dev --parameters fitted",
    )
    parser.add_argument("recordings", type=Path, metavar="DIR")
    parser.add_argument("--parameters", type=Path, required=True, metavar="FOLDER")
    asked = parser.parse_args(argv)
    profile = OWN_PROFILE[POLICY]
    numbers = {name: profile_parameters(name, asked.parameters) for name in PROFILES}
    one = contender(POLICY, profile, numbers)
    tried = [_counted(t, episodes) for t, episodes in _played(asked.recordings, one).items()]
    chosen = lowest_safe(tried)
    _print(tried, chosen)
    if chosen is None:
        return 1
    path = asked.parameters / f"{profile}.json"
    write_parameters(path, _with(one, chosen.at_least).parameters)
    print(f"Wrote {path}: commit_at_least {chosen.at_least}.")
    return 0


def _played(folder: Path, one: Contender) -> dict[float, list[EpisodeResult]]:
    """The episodes of every threshold."""
    scenes = recording_store.scenes(folder)
    splits.require("development", [seed for _, seed in scenes], "study commit")
    played: dict[float, list[EpisodeResult]] = {t: [] for t in GRID}
    contenders = [_with(one, t) for t in GRID]
    for results in track(_results(folder, scenes, contenders), "replaying", total=len(scenes)):
        for t, result in zip(GRID, results, strict=True):
            played[t].append(result)
    return played


def _results(
    folder: Path, scenes: Iterable[tuple[str, int]], contenders: Sequence[Contender]
) -> Iterator[list[EpisodeResult]]:
    cell = simulated_cell()
    for family, seed in scenes:
        recording = recording_store.load(folder, family, seed)
        scene = ready(recording, recording_store.load_truth(folder, family, seed))
        yield list(evaluate(scene, contenders, cell, Conditions()))


def _with(one: Contender, at_least: float) -> Contender:
    return replace(
        one, parameters=msgspec.structs.replace(one.parameters, commit_at_least=at_least)
    )


def _counted(at_least: float, episodes: Sequence[EpisodeResult]) -> Tried:
    return Tried(
        at_least=at_least,
        n_episodes=len(episodes),
        n_wrong=sum(any(not grasp.on_target for grasp in one.grasps) for one in episodes),
        n_successes=sum(one.verdict == "success" for one in episodes),
    )


def _print(tried: Iterable[Tried], chosen: Tried | None) -> None:
    table = Table("at least", "wrong", "upper bound", "successes", "")
    for one in tried:
        table.add_row(
            f"{one.at_least:.2f}",
            f"{one.n_wrong} of {one.n_episodes}",
            f"{100 * one.upper_bound:.2f} %",
            str(one.n_successes),
            "chosen" if one == chosen else "",
        )
    console = Console()
    console.print(table)
    if chosen is None:
        console.print("No threshold keeps wrong grasps so few; nothing was written.")
