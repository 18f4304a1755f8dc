"""`surefetch study gates`: the bounds that the scene generator must keep, on development scenes."""

import argparse
import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table

from surefetch.belief.episode import EpisodeBelief, rules_of, step
from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.parameters import Parameters, read_parameters, shipped_parameters
from surefetch.evaluation.fitting import gates
from surefetch.evaluation.fitting.gates import Gate, Walked
from surefetch.evaluation.fitting.sequences import beginnings, looks_along
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.recordings.recording import exhaustive_path
from surefetch.evaluation.running.metrics import Scored, wilson
from surefetch.evaluation.scenes import acceptance
from surefetch.evaluation.scenes.acceptance import Acceptance


def main(argv: list[str]) -> int:
    """Play the controls; exit code 1 when a bound is broken."""
    parser = argparse.ArgumentParser(
        prog="surefetch study gates",
        description="Play five policies without judgement on recorded development scenes, with "
        f"drawn outcomes (removal {gates.P_REMOVE}, view {gates.P_VIEW}, grasp {gates.P_GRASP}). "
        "Says too how many attempts at a scene the generator rejected, and why.",
        epilog="example: surefetch study gates --recordings dev --parameters fitted/paper.json",
    )
    parser.add_argument("--recordings", type=Path, required=True, metavar="DIR")
    parser.add_argument("--parameters", type=Path, metavar="FILE", help="default: those that ship")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args(argv)
    scenes = recording_store.scenes(asked.recordings)
    splits.require("development", [seed for _, seed in scenes], "study gates")
    if asked.parameters is None:
        parameters = shipped_parameters("paper")
    else:
        parameters = read_parameters(asked.parameters)
    cell = simulated_cell()
    played = gates.play_all(_walked(asked.recordings, parameters, cell), cell)
    judged = gates.judge(played)
    accepted = acceptance.by_family(
        recording_store.load_scene_truth(asked.recordings, family, seed) for family, seed in scenes
    )
    if asked.json:
        print(json.dumps(_plain(played, judged, accepted)))
    else:
        _print(played, judged)
        _print_accepted(accepted)
    return 0 if all(gate.passed for gate in judged) else 1


def _walked(folder: Path, parameters: Parameters, cell: Cell) -> list[Walked]:
    walked = []
    scenes = recording_store.scenes(folder)
    for recording, truth in track(
        recording_store.load_all(folder), "believing", total=len(scenes), transient=True
    ):
        found = beginnings(exhaustive_path(recording.covered, cell))
        begin = EpisodeBelief(rules_of(parameters, recording.target.relation))
        walks = looks_along(recording, truth, found, cell, begin, step, profile=parameters.profile)
        walked.append(Walked(recording, truth, walks))
    return walked


def _print(played: Mapping[str, Sequence[Scored]], judged: Sequence[Gate]) -> None:
    console = Console()
    table = Table("policy", *splits.FAMILIES, "all", "95 %", title="Successes, %")
    for name, episodes in played.items():
        by_family = [f"{100 * gates.share(episodes, family):.0f}" for family in splits.FAMILIES]
        n = sum(e.verdict == "success" for e in episodes)
        low, high = wilson(n, len(episodes))
        total = f"{100 * gates.share(episodes):.0f}"
        table.add_row(name, *by_family, total, f"{100 * low:.0f}–{100 * high:.0f}")
    console.print(table)
    for gate in judged:
        word = "kept  " if gate.passed else "BROKEN"
        console.print(
            f"{word} {gate.control}, {gate.family or 'all'}: {100 * gate.found:.1f} % "
            f"(allowed {100 * gate.low:.0f}–{100 * gate.high:.0f})"
        )


def _print_accepted(accepted: Mapping[str, Acceptance]) -> None:
    table = Table("family", "scenes", "attempts", "accepted", "rejected", title="The generator")
    for family, one in accepted.items():
        reasons = ", ".join(f"{reason} {n}" for reason, n in one.rejected.items())
        rate = f"{100 * one.rate:.0f} %"
        table.add_row(family, str(one.scenes), str(one.attempts), rate, reasons or "-")
    Console().print(table)


def _plain(
    played: Mapping[str, Sequence[Scored]],
    judged: Sequence[Gate],
    accepted: Mapping[str, Acceptance],
) -> dict[str, object]:
    return {
        "generator": {
            family: {"scenes": one.scenes, "attempts": one.attempts, "rejected": one.rejected}
            for family, one in accepted.items()
        },
        "policies": {
            name: {family: gates.share(episodes, family) for family in splits.FAMILIES}
            | {"all": gates.share(episodes), "episodes": len(episodes)}
            for name, episodes in played.items()
        },
        "gates": [
            {
                "control": gate.control,
                "family": gate.family,
                "low": gate.low,
                "high": gate.high,
                "found": gate.found,
                "passed": gate.passed,
            }
            for gate in judged
        ],
    }
