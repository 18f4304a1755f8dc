"""`surefetch study evaluate`: policies on recorded scenes."""

import argparse
import json
import sys
import tempfile
from pathlib import Path
from typing import Final

from rich.console import Console
from rich.progress import track

from surefetch.common import injections
from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES
from surefetch.common.policies import DEFAULT_PROFILE, OWN_PROFILE
from surefetch.evaluation.policies import registry
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.replaying import campaign, manifest, printing, results
from surefetch.evaluation.replaying.campaign import Campaign
from surefetch.evaluation.replaying.evaluate import Conditions
from surefetch.evaluation.replaying.manifest import Manifest
from surefetch.evaluation.replaying.outcomes import MODES, Mode, Rates
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.reporting import ledger

MOST_JOBS: Final = 64
RATES: Final = Rates()
NOTES: Final[dict[Mode, str]] = {
    "measured": "Removals and grasps of the target come out as they did in the simulator, views "
    f"succeed where they are feasible; grasps of wrong bodies are drawn ({RATES.grasp}, assumed).",
    "bernoulli": f"Outcomes are drawn (removal {RATES.remove}, view {RATES.view}, grasp "
    f"{RATES.grasp}: assumed, not measured); a failure moves nothing.",
}


def main(argv: list[str]) -> int:
    """Play what was not played yet, and print what came of it."""
    asked = _parser().parse_args(argv)
    notes = Console(stderr=True) if asked.json else Console()
    wanted = _campaign(asked)
    with tempfile.TemporaryDirectory() as nowhere:
        out = asked.out or Path(nowhere)
        _play(wanted, out, asked.jobs, f"surefetch study evaluate {' '.join(argv)}")
        played = {label: results.read(out, label) for label in wanted.policies}
    for note in (NOTES[wanted.conditions.mode], *printing.left(played)):
        notes.print(note, highlight=False)
    if asked.json:
        sys.stdout.write(json.dumps(printing.plain(played)) + "\n")
        return 0
    for table in (printing.successes, printing.endings, printing.efforts):
        notes.print(table(played))
    return 0


def _play(wanted: Campaign, out: Path, jobs: int, command: str) -> None:
    """Play the policies that are not there yet, as they are now."""
    made = manifest.made_with(wanted) | ledger.sealed(wanted.recordings)
    found = manifest.begin(out, made)
    now = {one.label: manifest.played_as(one, command) for one in wanted.contenders()}
    todo = [label for label in now if not manifest.is_played(out, found, label, now[label])]
    if not todo:
        return
    codes = {label: now[label]["code"] for label in todo}
    ledger.note(wanted.recordings, made, codes, command)
    played = _scenes(wanted.of(todo), jobs)
    kept = {name: told for name, told in found.policies.items() if name not in todo}
    manifest.write(out, Manifest(found.made_with, kept))
    for label in todo:
        results.write(out, label, (e for scene in played for e in scene if e.policy == label))
    manifest.write(out, Manifest(found.made_with, kept | {label: now[label] for label in todo}))


def _scenes(wanted: Campaign, jobs: int) -> list[list[EpisodeResult]]:
    n = len(recording_store.scenes(wanted.recordings))
    console = Console(stderr=True)
    running = campaign.run(wanted, jobs)
    return list(track(running, "replaying", total=n, transient=True, console=console))


def _campaign(asked: argparse.Namespace) -> Campaign:
    injected = tuple(injections.parse(word) for word in asked.inject or ())
    return Campaign(
        recordings=asked.recordings,
        policies=names(asked.policies),
        profile=asked.profile,
        parameters=asked.parameters,
        finish_live=asked.finish_live,
        conditions=Conditions(
            asked.outcomes or best_mode(asked.recordings), RATES, asked.outcome_seed, injected
        ),
    )


def best_mode(recordings: Path) -> Mode:
    """Measured outcomes, where all scenes have them."""
    scenes = recording_store.scenes(recordings)
    all_measured = all(recording_store.is_measured(recordings, *scene) for scene in scenes)
    return "measured" if all_measured else "bernoulli"


def names(listed: str) -> tuple[str, ...]:
    """Policies, listed with commas, each once. Raises BadInput where there are none."""
    names = [name.strip() for name in listed.split(",") if name.strip()]
    if not names:
        raise BadInput("--policies names none. Name some, with commas between: ours,paper-method")
    return tuple(dict.fromkeys(names))


def _parser() -> argparse.ArgumentParser:
    own = ", ".join(OWN_PROFILE)
    known = ", ".join([*registry.POLICIES, *registry.BOUNDS])
    parser = argparse.ArgumentParser(
        prog="surefetch study evaluate",
        description="Replay policies on recorded scenes: successes by family with Wilson "
        "intervals, endings, actions and costs. What is in the folder of results already is not "
        "played again.",
        epilog="example: surefetch study evaluate --recordings dev --out results "
        "--policies ours,paper-method,a6,exhaustive-look@paper",
    )
    parser.add_argument("--recordings", type=Path, required=True, metavar="DIR")
    parser.add_argument(
        "--policies",
        required=True,
        metavar="A,B,…",
        help=f"{known}, or package.module:Class of your own; each may end in @PROFILE",
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
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="where every episode is kept; default: nowhere"
    )
    parser.add_argument("--jobs", type=jobs, default=1, metavar="N", help="processes")
    parser.add_argument(
        "--outcomes",
        choices=MODES,
        help="of actions: as measured in the simulator, or drawn at assumed rates; default: "
        "measured where all scenes have them",
    )
    parser.add_argument(
        "--outcome-seed", type=int, default=0, metavar="K", help="another draw of the outcomes"
    )
    parser.add_argument(
        "--inject",
        action="append",
        metavar="KIND@K",
        help="report the K-th grasp, view or cover removal of every episode as failed; view@0.2: "
        "each with this chance",
    )
    parser.add_argument(
        "--finish-live",
        action="store_true",
        help="finish episodes that leave their recording in the simulator; without it they count "
        "as aborted",
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    return parser


def jobs(word: str) -> int:
    """A number of processes, as argparse takes it."""
    if word.isascii() and word.isdigit() and 1 <= int(word) <= MOST_JOBS:
        return int(word)
    raise argparse.ArgumentTypeError(f"a whole number from 1 to {MOST_JOBS}")
