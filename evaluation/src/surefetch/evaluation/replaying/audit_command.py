"""`surefetch study audit`: do recorded scenes go live as they go in replay?"""

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final

from rich.console import Console
from rich.table import Table

from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.errors import InfrastructureError
from surefetch.common.parameters import PROFILES, profile_parameters
from surefetch.common.policies import DEFAULT_PROFILE
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.replaying import audit, manifest
from surefetch.evaluation.replaying.audit import SAME, Comparison, Course
from surefetch.evaluation.replaying.audit_live import by_processes, has_processes, in_process
from surefetch.evaluation.replaying.contenders import Contender, contender
from surefetch.evaluation.replaying.evaluate import Conditions, world_of
from surefetch.evaluation.replaying.outcomes import Rates
from surefetch.evaluation.replaying.scene import RecordedScene, ready
from surefetch.evaluation.replaying.sitting import Sitting
from surefetch.evaluation.reporting import ledger
from surefetch.evaluation.running.cell import CellWanted, open_cell
from surefetch.evaluation.running.live import Live

EPISODES: Final = 6
NEVER_FAIL: Final = Rates(1.0, 1.0, 1.0)
"""In replay, where outcomes were not measured."""
Row = dict[str, Any]


def main(argv: list[str]) -> int:
    """Run, compare, print; 0 also where something differs, because the table says it."""
    asked = _parser().parse_args(argv)
    console = Console(stderr=asked.json, highlight=False)
    numbers = {name: profile_parameters(name, None) for name in PROFILES}
    contenders = [contender(label, DEFAULT_PROFILE, numbers) for label in asked.policies.split(",")]
    _log_opening(asked.recordings, contenders, f"surefetch study audit {' '.join(argv)}")
    scenes = list(_scenes(asked.recordings, asked.episodes))
    all_measured = all(scene.measured is not None for scene in scenes)
    conditions = Conditions("measured" if all_measured else "bernoulli", NEVER_FAIL)
    rows: list[Row] = []
    for one in contenders:
        for row in _audit(one, scenes, conditions, console):
            console.print(_line(row), soft_wrap=True)
            rows.append(row)
    console.print(_table(rows))
    if asked.json:
        sys.stdout.write(json.dumps({"same": SAME, "episodes": rows}) + "\n")
    return 0


def _log_opening(folder: Path, contenders: Sequence[Contender], command: str) -> None:
    """Where the scenes are of the evaluation split."""
    made = {
        "parameters": {
            one.profile.name: manifest.parameters_hash(one.parameters) for one in contenders
        },
        "outcomes": {"mode": "audit"},
        "injected": "",
    }
    codes = {one.label: manifest.code_hash(one) for one in contenders}
    ledger.note(folder, made, codes, command)


def _scenes(folder: Path, of_each_family: int) -> Iterator[RecordedScene]:
    left = dict.fromkeys(FAMILIES, of_each_family)
    for family, seed in recording_store.scenes(folder):
        if left[family] > 0:
            left[family] -= 1
            is_measured = recording_store.is_measured(folder, family, seed)
            yield ready(
                recording_store.load(folder, family, seed),
                recording_store.load_truth(folder, family, seed),
                measured=recording_store.load_measured(folder, family, seed)
                if is_measured
                else None,
            )


def _audit(
    one: Contender, scenes: Sequence[RecordedScene], conditions: Conditions, console: Console
) -> Iterator[Row]:
    cell = simulated_cell()
    with ExitStack() as stack:
        live = None
        for scene in scenes:
            if has_processes(one) and live is None:
                live = Live(stack.enter_context(open_cell(CellWanted(), console.print)))
            replayed = _replayed(one, scene, conditions, cell)
            try:
                course = (
                    in_process(one, scene, cell) if live is None else by_processes(live, one, scene)
                )
            except InfrastructureError as error:
                course = Course((), "aborted", "infrastructure", str(error))
            yield _row(one, scene, replayed, course)
            if course.outcome == "aborted" and live is not None:
                stack.pop_all().close()
                live = None


def _replayed(one: Contender, scene: RecordedScene, conditions: Conditions, cell: Cell) -> Course:
    sitting = Sitting.begin(one, scene, cell)
    world = world_of(scene, conditions, remembers=one.remembers)
    return audit.of_replay(sitting.play(world, sitting.beliefs()))


def _row(one: Contender, scene: RecordedScene, replayed: Course, live: Course) -> Row:
    found: Comparison = audit.compare(replayed, live)
    return {
        "policy": one.label,
        "live": "four processes" if has_processes(one) else "one process",
        "family": scene.recording.family,
        "seed": scene.recording.seed,
        "same_actions": found.same_actions,
        "same_outcome": found.same_outcome,
        "looks_compared": found.n_looks,
        "same_beliefs": found.same_beliefs,
        "apart": found.apart,
        "why": found.why,
        "replayed": [*replayed.actions, replayed.outcome],
        "run": [*live.actions, live.outcome],
    }


def _line(row: Row) -> str:
    where = f"{row['policy']} {row['family']}:{row['seed']}"
    same = f"the same {len(row['run']) - 1} actions" if row["same_actions"] else "other actions"
    why = f": {row['why']}" if row["why"] else ""
    return f"{where}: {same}, beliefs {row['apart']:.1e} apart{why}"


def _table(rows: Sequence[Row]) -> Table:
    table = Table("policy", "live by", "actions the same", "end the same", "beliefs within 1e-9",
                  "largest difference", title="Replay against live runs")  # fmt: skip
    for policy in dict.fromkeys(row["policy"] for row in rows):
        mine = [row for row in rows if row["policy"] == policy]
        counts = [
            sum(row["same_actions"] for row in mine),
            sum(row["same_outcome"] for row in mine),
            sum(row["same_beliefs"] for row in mine),
        ]
        table.add_row(
            policy,
            mine[0]["live"],
            *(f"{count}/{len(mine)}" for count in counts),
            f"{max(row['apart'] for row in mine):.1e}",
        )
    return table


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch study audit",
        description="Run recorded scenes live from their seeds, and tell whether actions, ends "
        "and beliefs are those of the replay. ours and paper-method are run by the four real "
        "processes, other policies by the same services' code in one process. Live actions come "
        "out as the simulator has it, replayed ones as was measured, or where nothing was measured "
        "without a failure: an action that fails on one side alone is a difference, and is named.",
        epilog="example: surefetch study audit --recordings dev --episodes 6 --policies ours,a3",
    )
    parser.add_argument("--recordings", type=Path, required=True, metavar="DIR")
    parser.add_argument(
        "--episodes", type=int, default=EPISODES, metavar="N", help="of each family (default: 6)"
    )
    parser.add_argument("--policies", default="ours", metavar="A,B,…", help="default: ours")
    parser.add_argument("--json", action="store_true", help="one JSON object on stdout")
    return parser
