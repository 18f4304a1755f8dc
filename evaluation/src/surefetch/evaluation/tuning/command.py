"""`surefetch study tune`: the numbers of policies, chosen on development recordings."""

import argparse
from collections.abc import Iterable
from pathlib import Path

import msgspec
from rich.console import Console
from rich.progress import track
from rich.table import Table

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES
from surefetch.evaluation.fitting.provenance import provenance
from surefetch.evaluation.policies import registry, tuning
from surefetch.evaluation.policies.fixed_sequence import BestFixed
from surefetch.evaluation.policies.tuning import MOST_CONFIGURATIONS, Tuned, TunedOn
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.replaying import manifest
from surefetch.evaluation.replaying.campaign import Campaign
from surefetch.evaluation.replaying.command import RATES, best_mode, jobs, names
from surefetch.evaluation.replaying.contenders import WITH, Contender
from surefetch.evaluation.replaying.evaluate import Conditions
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.tuning.tune import tune, tune_sequences


def main(argv: list[str]) -> int:
    """Tune each policy on each belief, and write what was chosen and all that was tried."""
    asked = _parser().parse_args(argv)
    command = f"surefetch study tune {' '.join(argv)}"
    chosen = []
    for wanted in _campaigns(asked):
        for one in wanted.contenders():
            on = _tuned_on(wanted, one, command)
            chosen.append(_tuned(wanted, one, on, asked.jobs))
            write(asked.out, chosen[-1])
    Console().print(_table(chosen))
    print(f"Wrote {len(chosen)} files to {asked.out}.")
    return 0


def write(folder: Path, tuned: Tuned) -> None:
    """Write the file of one policy on one belief, for people to read."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / tuning.name_of(tuned.policy, tuned.profile)
    path.write_bytes(msgspec.json.format(msgspec.json.encode(tuned), indent=1) + b"\n")


def _campaigns(asked: argparse.Namespace) -> list[Campaign]:
    """One for each belief. Raises BadInput for recordings of another split."""
    scenes = recording_store.scenes(asked.recordings)
    splits.require("development", [seed for _, seed in scenes], "study tune")
    beliefs = PROFILES if asked.profile is None else (asked.profile,)
    policies = names(asked.policies)
    if labelled := [name for name in policies if WITH in name or "[" in name]:
        raise BadInput(
            f'"{labelled[0]}": name policies without belief and values; --profile says which '
            "belief, and all values of the grid are tried."
        )
    return [
        Campaign(
            recordings=asked.recordings,
            policies=tuple(f"{name}{WITH}{profile}" for name in policies),
            profile=profile,
            parameters=asked.parameters,
            conditions=Conditions(best_mode(asked.recordings), RATES),
        )
        for profile in beliefs
    ]


def _tuned(wanted: Campaign, one: Contender, on: TunedOn, n_jobs: int) -> Tuned:
    if one.entry is None or not (one.entry.scalars or one.entry.cross_fitted):
        raise BadInput(f'"{one.name}" has nothing that is tuned.')
    n = len(recording_store.scenes(wanted.recordings))
    console = Console(stderr=True)

    def watch(results: Iterable[list[EpisodeResult]]) -> Iterable[list[EpisodeResult]]:
        return track(results, one.label, total=n, transient=True, console=console)

    if registry.find(one.name).make is BestFixed:
        return tune_sequences(wanted, one, on, watch)
    return tune(wanted, one, on, n_jobs, watch)


def _tuned_on(wanted: Campaign, one: Contender, command: str) -> TunedOn:
    scenes = recording_store.scenes(wanted.recordings)
    made = manifest.made_with(wanted)
    backend = recording_store.load(wanted.recordings, *scenes[0]).backend
    return TunedOn(
        scenes=provenance(simulated_cell(), backend, "development", scenes, "tuned by replay"),
        parameters=made["parameters"][one.profile.name],
        outcomes=made["outcomes"]["mode"],
        command=command,
    )


def _table(chosen: Iterable[Tuned]) -> Table:
    table = Table("policy", "chosen", "successes", "realised cost", "tried", title="Development")
    for one in chosen:
        best = tuning.best(one.trials)
        table.add_row(
            f"{one.policy}{WITH}{one.profile}",
            ", ".join(f"{name} {value:g}" for name, value in one.values.items()) or "-",
            f"{best.n_successes} of {one.tuned_on.scenes.n_episodes}",
            f"{best.mean_realized_cost:.4f}",
            str(len(one.trials)),
        )
    return table


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch study tune",
        description="Replay every configuration of policies on development recordings, at most "
        f"{MOST_CONFIGURATIONS} each, and keep the one with the most successes, of equals the one "
        "with the least realised cost. A policy that learned from development scenes plays each "
        "as it is without that scene's fold. Writes FOLDER/NAME@PROFILE.json: what was chosen, "
        "and everything that was tried.",
        epilog="example: surefetch study tune --recordings dev --policies "
        "exhaustive-look,greedy-threshold,best-fixed --out tuned",
    )
    parser.add_argument("--recordings", type=Path, required=True, metavar="DIR")
    parser.add_argument("--policies", required=True, metavar="A,B,…")
    parser.add_argument("--profile", choices=PROFILES, help="only for this belief; default: both")
    parser.add_argument(
        "--parameters", type=Path, metavar="FOLDER", help="default: those that ship"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--jobs", type=jobs, default=1, metavar="N", help="processes")
    return parser
