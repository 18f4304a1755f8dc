"""`surefetch study episodes`: closed-loop episodes over the real processes, many in a row.

``DIR/episodes.jsonl`` grows by a line an episode, so that the study resumes where it ended; a run
that did not end well is kept in ``DIR/runs/FAMILY-SEED``.
"""

import argparse
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from rich.console import Console
from rich.table import Table

from surefetch.common import injections, policies
from surefetch.common.errors import BadInput
from surefetch.common.messages import Injection
from surefetch.common.version import VERSION
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.running import metrics
from surefetch.evaluation.running.cell import CellWanted, open_cell
from surefetch.evaluation.running.live import Live
from surefetch.evaluation.running.request import INJECT_HELP
from surefetch.evaluation.running.study_episode import KeptAs, run_one
from surefetch.evaluation.scenes.candidate import GENERATOR_VERSION

EPISODES: Final = "episodes.jsonl"
RUNS: Final = "runs"


@dataclass(frozen=True)
class Study:
    """What is asked for."""

    scenes: tuple[tuple[str, int], ...]
    """Families and seeds, families interleaved."""
    profile: str
    policy: str
    out: Path
    config: Path | None
    injected: tuple[Injection, ...]
    json: bool


def main(argv: list[str]) -> int:
    """Run what is missing, then show the table. 130 when it was interrupted."""
    study = _read(argv)
    console = Console(stderr=study.json, highlight=False)
    _begin(study)
    rows = _rows(study.out)
    todo = [
        scene for scene in study.scenes if scene not in {(r["family"], r["seed"]) for r in rows}
    ]
    console.print(f"{len(study.scenes)} episodes, {len(study.scenes) - len(todo)} there already")
    for row in _run_all(study, todo, console.print):
        with (study.out / EPISODES).open("a", encoding="utf-8") as file:
            file.write(json.dumps(row, allow_nan=False, ensure_ascii=False) + "\n")
        console.print(_line(row), soft_wrap=True)
    wanted = set(study.scenes)
    rows = [row for row in _rows(study.out) if (row["family"], row["seed"]) in wanted]
    told = report(rows) | {"profile": study.profile, "policy": study.policy}
    _show(console, told, rows)
    if study.json:
        print(json.dumps(told, allow_nan=False), flush=True)
    return 0


def report(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Successes with intervals and failure classes, by family and in all. Pure.

    Episodes that ended for want of infrastructure before their first look do not count.
    """
    counted = [_scored(row) for row in rows if row["begun"]]
    families = metrics.by_family(counted)
    for family, cells in families.items():
        of_family = [episode for episode in counted if episode.family == family]
        cells["classes"] = dict(metrics.failure_classes(of_family))
        cells["realized_cost"] = _mean([metrics.realized_cost(e) for e in of_family])
    return {
        "families": families,
        "all": metrics.row(counted) | {"classes": dict(metrics.failure_classes(counted))},
        "excluded": len(rows) - len(counted),
    }


def _scored(row: dict[str, Any]) -> metrics.Scored:
    return metrics.Scored(
        family=row["family"],
        seed=row["seed"],
        verdict=row["verdict"],
        actions=len(row["actions"]),
        cost=row["cost"],
    )


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values) if values else 0.0


def _run_all(
    study: Study, todo: Sequence[tuple[str, int]], say: Callable[[str], None]
) -> Iterator[dict[str, Any]]:
    """One row an episode; four services serve many, and are started anew after an abort."""
    kept = KeptAs(study.profile, study.policy, study.out / RUNS, study.injected)
    left = list(todo)
    while left:
        with open_cell(CellWanted(config=study.config), say) as cell:
            live = Live(cell)
            while left:
                row = run_one(live, kept, *left.pop(0))
                if row["outcome"] == "stopped":
                    raise KeyboardInterrupt
                yield row
                if row["outcome"] == "aborted":
                    break


def _begin(study: Study) -> None:
    made_with = {
        "profile": study.profile,
        "policy": study.policy,
        "generator_version": GENERATOR_VERSION,
        "surefetch": VERSION,
    }
    if study.injected:
        made_with["injected"] = injections.told(study.injected)
    recording_store.write_manifest(study.out, made_with)


def _rows(out: Path) -> list[dict[str, Any]]:
    """The episodes that are there. Raises BadInput for a damaged file."""
    path = out / EPISODES
    if not path.exists():
        return []
    try:
        return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    except ValueError as error:
        raise BadInput(f"{path} is damaged: {error}\n  Take its last line away.") from None


def _line(row: dict[str, Any]) -> str:
    scene = f"{row['family']}:{row['seed']}".ljust(18)
    cause = f"  {row['cause']}: {row['why']}" if row["cause"] else ""
    seconds = row.get("durations", {}).get("total", 0.0)
    return f"{scene} {row['verdict']:<18} {seconds:5.1f} s{cause}"


def _show(console: Console, told: dict[str, Any], rows: Sequence[dict[str, Any]]) -> None:
    table = Table(title=f"{told['policy']}, profile {told['profile']}", title_justify="left")
    classes = [name for name in metrics.VERDICTS if told["all"]["classes"].get(name)]
    table.add_column("family")
    for name in ("successes", "95 % interval", *(c.replace("_", " ") for c in classes[1:])):
        table.add_column(name, justify="right")
    for family, cells in (*told["families"].items(), ("all", told["all"])):
        low, high = cells["wilson_95"]
        table.add_row(
            family,
            f"{cells['successes']}/{cells['episodes']}",
            f"{100 * low:.1f}–{100 * high:.1f}",
            *(str(cells["classes"][name]) for name in classes[1:]),
        )
    console.print(table)
    for row in rows:
        if row["verdict"] != "success":
            console.print(_line(row), soft_wrap=True)


def _read(argv: Sequence[str]) -> Study:
    parser = argparse.ArgumentParser(
        prog="surefetch study episodes",
        description="Closed-loop episodes over the four real processes, with a table of "
        "successes and the cause of every failure. What is there already is not run again.",
        epilog="example: surefetch study episodes --seeds 100:110 --out study/extended",
    )
    parser.add_argument("--seeds", required=True, metavar="A:B", help="half-open; of each family")
    parser.add_argument("--families", metavar="F,…", help="default: all five")
    parser.add_argument("--profile", metavar="P", help="extended (default) or paper")
    parser.add_argument("--policy", metavar="NAME", help=f"{', '.join(policies.OWN_PROFILE)}")
    parser.add_argument("--config", type=Path, metavar="F", help="TOML file of the cell")
    parser.add_argument("--inject", action="append", metavar="KIND@K", help=INJECT_HELP)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument("--json", action="store_true", help="the tables as stdout's last line")
    told = parser.parse_args(argv)
    profile, policy = policies.choose(told.profile, told.policy)
    seeds, families = splits.seeds_of(None, None, told.seeds), splits.families_of(told.families)
    return Study(
        scenes=tuple((family, seed) for seed in seeds for family in families),
        profile=profile,
        policy=policy,
        out=told.out,
        config=told.config,
        injected=tuple(injections.parse(word) for word in told.inject or ()),
        json=told.json,
    )
