"""`surefetch study evaluate`: policies on recorded scenes."""

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console
from rich.progress import track

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES, profile_parameters
from surefetch.common.policies import DEFAULT_PROFILE, OWN_PROFILE
from surefetch.evaluation.policies import registry
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.recordings.recording import Recording, RecordingTruth
from surefetch.evaluation.replaying import printing
from surefetch.evaluation.replaying.evaluate import Results, contender, evaluate
from surefetch.evaluation.replaying.outcomes import Rates

RATES = Rates()
NOTES = (
    f"Outcomes are drawn (removal {RATES.remove}, view {RATES.view}, grasp {RATES.grasp}: assumed, "
    "not measured), the same for every policy.",
    "Recordings do not tell what the robot could do: every view, removal and grasp counts as "
    "feasible, and a failed grasp as moving nothing.",
    f"exhaustive-look and greedy-threshold grasp from a belief of {registry.AT_LEAST}, not tuned.",
)


def main(argv: list[str]) -> int:
    """Replay policies and print what came of it."""
    asked = _parser().parse_args(argv)
    names = _names(asked.policies)
    parameters = {name: profile_parameters(name, asked.parameters) for name in PROFILES}
    contenders = [contender(name, asked.profile, parameters) for name in names]
    results = evaluate(_scenes(asked.recordings), contenders, simulated_cell(), RATES)
    notes = Console(stderr=True) if asked.json else Console()
    for note in (*NOTES, *_left(results)):
        notes.print(note, highlight=False)
    if asked.json:
        sys.stdout.write(json.dumps(printing.plain(results.scored)) + "\n")
        return 0
    for table in (printing.successes, printing.endings, printing.efforts):
        notes.print(table(results.scored))
    return 0


def _parser() -> argparse.ArgumentParser:
    own = ", ".join(OWN_PROFILE)
    known = ", ".join([*registry.POLICIES, registry.ORACLE])
    parser = argparse.ArgumentParser(
        prog="surefetch study evaluate",
        description="Replay policies on recorded scenes: successes by family with Wilson "
        "intervals, endings, actions and costs.",
        epilog="example: surefetch study evaluate --recordings dev --policies ours,paper-method,a6",
    )
    parser.add_argument("--recordings", type=Path, required=True, metavar="DIR")
    parser.add_argument(
        "--policies",
        required=True,
        metavar="A,B,…",
        help=f"{known}, or package.module:Class of your own",
    )
    parser.add_argument(
        "--profile",
        choices=PROFILES,
        default=DEFAULT_PROFILE,
        help=f"belief and failure rules (default: {DEFAULT_PROFILE}); {own} keep their own",
    )
    parser.add_argument(
        "--parameters", type=Path, metavar="FOLDER", help="default: those that ship"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    return parser


def _names(listed: str) -> list[str]:
    names = [name.strip() for name in listed.split(",") if name.strip()]
    if not names:
        raise BadInput("--policies names none. Name some, with commas between: ours,paper-method")
    return list(dict.fromkeys(names))


def _scenes(folder: Path) -> Iterator[tuple[Recording, RecordingTruth]]:
    n = len(recording_store.scenes(folder))
    return iter(
        track(
            recording_store.load_all(folder), "replaying", total=n, transient=True,
            console=Console(stderr=True),
        )
    )  # fmt: skip


def _left(results: Results) -> Iterator[str]:
    for name, why in results.left_recording.items():
        if why:
            yield (
                f"{name} left the recording in {len(why)} episodes, which count as aborted. "
                f"First: {why[0]}"
            )
