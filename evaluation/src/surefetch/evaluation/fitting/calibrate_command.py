"""`surefetch study calibrate`: calibration recordings to conformal thresholds."""

import argparse
import math
import statistics
from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import Final

import msgspec
from rich.progress import track

from surefetch.belief.episode import EpisodeBelief
from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.parameters import (
    PROFILES,
    Calibration,
    Parameters,
    Provenance,
    Scores,
    check_origin,
    read_parameters,
    write_parameters,
)
from surefetch.evaluation.fitting import calibrate
from surefetch.evaluation.fitting.provenance import one_backend, provenance
from surefetch.evaluation.fitting.sequences import allowed_sequences, beginnings, looks_along
from surefetch.evaluation.fitting.variants import VARIANTS, believed, remembers, rules_for
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.recordings.recording import (
    Recording,
    RecordingTruth,
    exhaustive_path,
)
from surefetch.evaluation.recordings.walk import Look

ALPHA: Final = Fraction(1, 10)
ALONG: Final = {"paper": "exhaustive-look paths", "extended": "all sequences of looks"}
"""By profile, what an episode's score is the worst of."""


def main(argv: list[str]) -> int:
    """Calibrate fitted parameters on calibration recordings."""
    parser = argparse.ArgumentParser(
        prog="surefetch study calibrate",
        description="Find the conformal thresholds of fitted parameters, one for the whole belief "
        "and one for each ablation that changes it, on calibration recordings: for paper "
        "along exhaustive-look paths, for extended over all sequences of looks, so that they hold "
        "for every policy; rewrites FOLDER/PROFILE.json.",
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
        backend = one_backend(backend, recording)
        check_origin(parameters, cell=recording.cell, backend=recording.backend)
        for variant, found in scores.items():
            looks = _looks(recording, truth, cell, parameters, variant)
            found.append(calibrate.score(looks))
    origin = provenance(cell, backend, "calibration", used, ALONG[parameters.profile])
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


def _looks(
    recording: Recording, truth: RecordingTruth, cell: Cell, parameters: Parameters, variant: str
) -> list[Look]:
    """Every look of an episode that its score is the worst of."""
    found = _sequences(recording, parameters.profile, cell)
    rules = rules_for(parameters, recording.target.relation, variant, math.inf)
    walks = looks_along(
        recording, truth, found, cell, EpisodeBelief(rules), partial(believed, variant=variant),
        profile=parameters.profile, remembers=remembers(variant),
    )  # fmt: skip
    return [looks[-1] for looks in walks.values()]


def _sequences(recording: Recording, profile: str, cell: Cell) -> list[tuple[str, ...]]:
    """The sequences whose last looks count, each after its beginnings."""
    if profile == "paper":
        return beginnings(exhaustive_path(recording.covered, cell))
    return allowed_sequences(recording, profile, cell)
