"""Nonconformity scores of calibration scenes, for levels other than the calibrated one."""

import math
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import track

from surefetch.belief.episode import EpisodeBelief
from surefetch.common.cell import Cell
from surefetch.common.parameters import FULL, Parameters
from surefetch.evaluation.fitting import calibrate
from surefetch.evaluation.fitting.sequences import allowed_sequences, looks_along
from surefetch.evaluation.fitting.variants import believed, rules_for
from surefetch.evaluation.recordings import recording_store, splits
from surefetch.evaluation.recordings.recording import exhaustive_path


def scores(parameters: Parameters, folder: Path, cell: Cell) -> list[float]:
    """One a calibration scene, of the full belief, along the looks that calibration walks.

    Raises:
        BadInput: the scenes are not of the calibration split, or are too few.
    """
    scenes = recording_store.scenes(folder)
    splits.require("calibration", [seed for _, seed in scenes], "study report --calibration")
    used = scenes[: calibrate.episodes_for(parameters.profile, len(scenes))]
    console = Console(stderr=True)
    return [
        _score(parameters, folder, scene, cell)
        for scene in track(used, "calibration scores", transient=True, console=console)
    ]


def _score(parameters: Parameters, folder: Path, scene: tuple[str, int], cell: Cell) -> float:
    recording = recording_store.load(folder, *scene)
    truth = recording_store.load_truth(folder, *scene)
    path = exhaustive_path(recording.covered, cell)
    found = (
        [path[:n] for n in range(len(path) + 1)]
        if parameters.profile == "paper"
        else allowed_sequences(recording, parameters.profile, cell)
    )
    rules = rules_for(parameters, recording.target.relation, FULL, math.inf)
    step = partial(believed, variant=FULL)
    walks = looks_along(
        recording, truth, found, cell, EpisodeBelief(rules), step, profile=parameters.profile
    )
    return calibrate.score([looks[-1] for looks in walks.values()])
