"""`surefetch study fit` and `surefetch study calibrate`: recordings to parameter files."""

import argparse
import json
import math
import statistics
from collections.abc import Iterable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

import msgspec
from rich.progress import track

from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.parameters import (
    FULL,
    PRINTED,
    PROFILES,
    Calibration,
    Parameters,
    Priors,
    Provenance,
    Scores,
    check_origin,
    read_parameters,
    write_parameters,
)
from surefetch.evaluation.fitting import calibrate, evidence_gain, fit, trials
from surefetch.evaluation.fitting.believe import fresh_belief
from surefetch.evaluation.fitting.evidence_switches import SWITCHES, turned_on
from surefetch.evaluation.fitting.variants import VARIANTS, fresh_variant, remembers
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.recordings.recording import (
    Recording,
    RecordingTruth,
    exhaustive_path,
    paths,
)
from surefetch.evaluation.recordings.story import Story, tell, total
from surefetch.evaluation.recordings.walk import Look, walk

ALPHA: Final = Fraction(1, 10)


def main_fit(argv: list[str]) -> int:
    """Fit both profiles on development recordings."""
    parser = argparse.ArgumentParser(
        prog="surefetch study fit",
        description="Fit the observation model, its future twin and the priors on development "
        "recordings, and for the profile extended what its switches put in their place; writes "
        "paper.json and extended.json, not yet calibrated, and says what each switch is worth.",
        epilog="example: surefetch study fit dev --out fitted",
    )
    parser.add_argument("recordings", type=Path, metavar="DIR")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    parser.add_argument(
        "--trials",
        type=Path,
        metavar="EPISODES",
        help="episodes.jsonl of `surefetch study episodes` on development seeds, for p_remove and "
        "p_grasp of the profile extended; without it they are the paper's",
    )
    parser.add_argument(
        "--without",
        choices=SWITCHES,
        action="append",
        default=[],
        metavar="SWITCH",
        help=f"leave this switch of extended off: {', '.join(SWITCHES)}; may be repeated",
    )
    asked = parser.parse_args(argv)
    cell = simulated_cell()
    stories, origin = tell_all(asked.recordings, cell)
    attempts = None if asked.trials is None else read_attempts(asked.trials)
    asked.out.mkdir(parents=True, exist_ok=True)
    for profile in PROFILES:
        parameters = fitted(profile, stories, origin, attempts, cell)
        if profile == "extended":
            parameters = turned_on(parameters, stories, SWITCHES.keys() - set(asked.without))
        write_parameters(asked.out / f"{profile}.json", parameters)
    print(_switch_report(stories, lambda half: fitted("extended", half, origin, attempts, cell)))
    print(_fit_report(total(stories), origin, asked.out))
    return 0


def main_calibrate(argv: list[str]) -> int:
    """Calibrate fitted parameters on calibration recordings."""
    parser = argparse.ArgumentParser(
        prog="surefetch study calibrate",
        description="Find the conformal thresholds of fitted parameters, one for the whole belief "
        "and one for each ablation that changes it, along exhaustive-look paths of calibration "
        "recordings; rewrites FOLDER/PROFILE.json.",
        epilog="example: surefetch study calibrate calibration --parameters fitted",
    )
    parser.add_argument("recordings", type=Path, metavar="DIR")
    parser.add_argument("--parameters", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--profile", choices=PROFILES, help="only this one")
    asked = parser.parse_args(argv)
    for profile in PROFILES if asked.profile is None else (asked.profile,):
        path = asked.parameters / f"{profile}.json"
        calibrated = with_threshold(read_parameters(path), asked.recordings, simulated_cell())
        write_parameters(path, calibrated)
        for variant, found in calibrated.calibrations.items():
            low, high = found.coverage_range
            print(
                f"{profile}, {variant}: q_hat {found.q_hat} from {found.provenance.n_episodes} "
                f"episodes; true coverage between {low:.3f} and {high:.3f} (5 % to 95 %)."
            )
        print(f"Wrote {path}.")
    return 0


def tell_all(folder: Path, cell: Cell) -> tuple[list[Story], Provenance]:
    """What all development recordings of a folder contribute, and where it comes from."""
    scenes = recording_store.scenes(folder)
    splits.require("development", [seed for _, seed in scenes], "study fit")
    stories, backend = [], ""
    for recording, truth in track(
        recording_store.load_all(folder), "counting", total=len(scenes), transient=True
    ):
        backend = _one_backend(backend, recording)
        stories.append(_story(recording, truth, cell))
    return stories, _provenance(cell, backend, "development", scenes, "")


def _story(recording: Recording, truth: RecordingTruth, cell: Cell) -> Story:
    exhaustive = exhaustive_path(recording.covered, cell)
    walks = {
        path: walk(recording, truth, path, cell, fresh_belief(None), profile="paper")
        for path in paths(recording.covered, cell)
    }
    counts = fit.count(walks, exhaustive, truth.relation)
    return tell(recording, truth, walks[exhaustive], counts)


def fitted(
    profile: str,
    stories: Sequence[Story],
    origin: Provenance,
    attempts: Sequence[trials.Attempt] | None,
    cell: Cell,
) -> Parameters:
    """Parameters of one profile, all switches off; `paper` keeps the printed priors."""
    counts = total(stories)
    priors = PRINTED if profile == "paper" else _priors(counts, attempts, cell)
    return Parameters(
        profile=profile,
        fitted_on=origin,
        priors=priors,
        emissions=fit.emission_table(counts),
        paired=fit.paired_table(counts),
        calibrations={FULL: _uncalibrated(origin)},
    )


def _priors(counts: fit.Counts, attempts: Sequence[trials.Attempt] | None, cell: Cell) -> Priors:
    found = fit.priors(counts)
    p_remove, p_grasp = PRINTED.p_remove, PRINTED.p_grasp
    if attempts is not None:
        p_remove = trials.chance(*trials.groups(attempts, trials.removals(cell)))
        p_grasp = trials.chance(*trials.groups(attempts, frozenset({"grasp"})))
    return Priors(
        relation={"inside": found["inside"], "outside": 1.0 - found["inside"]},
        absent=found["abs"],
        unobserved=found["unobs"],
        tracked=1.0 - found["abs"] - found["unobs"],
        birth=found["beta_birth"],
        p_remove=p_remove,
        p_grasp=p_grasp,
    )


def with_threshold(parameters: Parameters, folder: Path, cell: Cell) -> Parameters:
    """The parameters with the threshold that calibration recordings give each variant."""
    scenes = recording_store.scenes(folder)
    splits.require("calibration", [seed for _, seed in scenes], "study calibrate")
    used = scenes[: calibrate.episodes_for(parameters.profile, len(scenes))]
    scores: dict[str, list[float]] = {variant: [] for variant in VARIANTS}
    backend = ""
    for family, seed in track(used, f"scoring {parameters.profile}", transient=True):
        recording = recording_store.load(folder, family, seed)
        truth = recording_store.load_truth(folder, family, seed)
        backend = _one_backend(backend, recording)
        check_origin(parameters, cell=recording.cell, backend=recording.backend)
        for variant, found in scores.items():
            looks = _exhaustive(recording, truth, cell, parameters, variant)
            found.append(calibrate.score(looks))
    origin = _provenance(cell, backend, "calibration", used, "exhaustive-look paths")
    made = {variant: _calibration(found, origin) for variant, found in scores.items()}
    return msgspec.structs.replace(parameters, calibrations=parameters.calibrations | made)


def _calibration(scores: Sequence[float], origin: Provenance) -> Calibration:
    found = calibrate.calibrate(scores, ALPHA)
    return Calibration(
        q_hat="inf" if math.isinf(found.q_hat) else found.q_hat,
        alpha="0.1",
        scores=Scores(smallest=min(scores), median=statistics.median(scores), largest=max(scores)),
        coverage_range=found.true_coverage,
        provenance=origin,
    )


def _exhaustive(
    recording: Recording, truth: RecordingTruth, cell: Cell, parameters: Parameters, variant: str
) -> list[Look]:
    path = exhaustive_path(recording.covered, cell)
    believe = fresh_variant(parameters, variant, math.inf)
    return walk(
        recording, truth, path, cell, believe,
        profile=parameters.profile, remembers=remembers(variant),
    )  # fmt: skip


def _one_backend(earlier: str, recording: Recording) -> str:
    if earlier not in ("", recording.backend):
        raise BadInput(
            f"the recordings come from two perceptions, {earlier} and {recording.backend}; "
            "parameters belong to one. Keep them in folders of their own."
        )
    return recording.backend


def _uncalibrated(origin: Provenance) -> Calibration:
    return Calibration(
        q_hat="inf",
        alpha="0.1",
        scores=None,
        coverage_range=(1.0, 1.0),
        provenance=msgspec.structs.replace(
            origin, split="none", n_episodes=0, seeds="", note="not calibrated yet"
        ),
    )


def _provenance(
    cell: Cell, backend: str, split: str, scenes: Iterable[tuple[str, int]], note: str
) -> Provenance:
    chosen = list(scenes)
    return Provenance(
        cell=cell.name,
        backend=backend,
        split=split,
        n_episodes=len(chosen),
        seeds=_ranges(sorted({seed for _, seed in chosen})),
        note=note,
    )


def _ranges(seeds: Sequence[int]) -> str:
    """Sorted seeds as half-open ranges, ``"100000:100040 100050:100060"``."""
    runs: list[list[int]] = []
    for seed in seeds:
        if runs and runs[-1][1] == seed:
            runs[-1][1] = seed + 1
        else:
            runs.append([seed, seed + 1])
    return " ".join(f"{start}:{stop}" for start, stop in runs)


def read_attempts(path: Path) -> list[trials.Attempt]:
    """The executed actions of a file that `study episodes` wrote.

    Raises:
        BadInput: the file is damaged, or holds scenes of another split.
    """
    attempts = []
    try:
        for line in path.read_text(encoding="utf-8").splitlines():
            episode: dict[str, Any] = json.loads(line)
            splits.require("development", [episode["seed"]], "study fit --trials")
            scene = f"{episode['family']}:{episode['seed']}"
            attempts += [
                trials.Attempt(scene, action["action"], action["status"] == "done")
                for action in episode["actions"]
            ]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise BadInput(
            f"{path} is no episodes.jsonl of `surefetch study episodes`: {error}"
        ) from None
    return attempts


def _switch_report(stories: Sequence[Story], fit_off: evidence_gain.Fit) -> str:
    if len({story.seed % 2 for story in stories}) < 2:
        return "What the switches are worth needs scenes of even and of odd seeds."
    return evidence_gain.table(evidence_gain.worth(stories, fit_off))


def _fit_report(counts: fit.Counts, origin: Provenance, out: Path) -> str:
    cells = len({key[:3] for key in counts.paired})
    return (
        f"{origin.n_episodes} development scenes: {counts.emission.total()} observations, "
        f"{counts.paired.total()} pairs in {cells} distributions. Wrote {out}/paper.json and "
        f"{out}/extended.json.\n"
        f"Calibrate them: surefetch study calibrate DIR --parameters {out}"
    )
