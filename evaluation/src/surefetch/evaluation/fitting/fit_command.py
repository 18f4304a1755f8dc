"""`surefetch study fit`: development recordings to parameter files."""

import argparse
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import msgspec
from rich.progress import track

from surefetch.belief.episode import EpisodeBelief, Rules, step
from surefetch.belief.evidence import CategoryEvidence
from surefetch.belief.filter import Model
from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.emission import Emission
from surefetch.common.errors import BadInput
from surefetch.common.parameters import (
    FULL,
    PRINTED,
    PROFILES,
    Calibration,
    Parameters,
    Priors,
    Provenance,
    write_parameters,
)
from surefetch.evaluation.fitting import evidence_gain, fit, trials
from surefetch.evaluation.fitting.evidence_switches import SWITCHES, turned_on
from surefetch.evaluation.fitting.provenance import one_backend, provenance
from surefetch.evaluation.fitting.sequences import allowed_sequences, longest, looks_along
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.recordings.recording import Recording, RecordingTruth
from surefetch.evaluation.recordings.story import Story, tell, total

BEFORE_FITTING: Final = Rules(Model(CategoryEvidence(Emission({})), PRINTED), math.inf)
"""Tracks and observations do not depend on what is fitted from them."""


def main(argv: list[str]) -> int:
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
    print(_fit_report(total(stories, "extended"), origin, asked.out))
    return 0


def tell_all(folder: Path, cell: Cell) -> tuple[list[Story], Provenance]:
    """What all development recordings of a folder contribute, and where it comes from."""
    scenes = recording_store.scenes(folder)
    splits.require("development", [seed for _, seed in scenes], "study fit")
    stories, backend = [], ""
    for recording, truth in track(
        recording_store.load_all(folder), "counting", total=len(scenes), transient=True
    ):
        backend = one_backend(backend, recording)
        stories.append(_story(recording, truth, cell))
    return stories, provenance(cell, backend, "development", scenes, "")


def _story(recording: Recording, truth: RecordingTruth, cell: Cell) -> Story:
    allowed = {profile: allowed_sequences(recording, profile, cell) for profile in PROFILES}
    every = dict.fromkeys(path for found in allowed.values() for path in found)
    begin = EpisodeBelief(BEFORE_FITTING)
    looks = looks_along(recording, truth, every, cell, begin, step, profile="extended")
    counts = {
        profile: fit.count({path: looks[path] for path in found}, longest(found), truth.relation)
        for profile, found in allowed.items()
    }
    return tell(recording, truth, looks[longest(every)], counts)


def fitted(
    profile: str,
    stories: Sequence[Story],
    origin: Provenance,
    attempts: Sequence[trials.Attempt] | None,
    cell: Cell,
) -> Parameters:
    """Parameters of one profile, all switches off; `paper` keeps the printed priors."""
    counts = total(stories, profile)
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
