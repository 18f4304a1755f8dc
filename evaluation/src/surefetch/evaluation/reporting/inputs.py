"""Reads everything that a report is made from."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES, Parameters, profile_parameters
from surefetch.evaluation.replaying import manifest, results
from surefetch.evaluation.reporting import calibration_scores, ledger, scene_facts
from surefetch.evaluation.reporting.ledger import Opening
from surefetch.evaluation.reporting.scene_facts import Address, Facts
from surefetch.evaluation.reporting.study_results import Study, study


@dataclass(frozen=True)
class Sources:
    """Where things are; None: not at hand."""

    results: Path
    recordings: Path | None = None
    also: tuple[Path, ...] = ()
    parameters: Path | None = None
    """Folder; None: those that ship."""
    calibration: Path | None = None
    perception: Path | None = None
    trials: Path | None = None
    audit: Path | None = None


@dataclass(frozen=True, eq=False)
class Inputs:
    """Everything, read."""

    study: Study
    injected: tuple[Study, ...]
    others: tuple[Study, ...]
    """Further folders without injected failures."""
    facts: Mapping[Address, Facts] | None
    openings: tuple[Opening, ...]
    parameters: Mapping[str, Parameters] | None
    """None: the results were made with others than those at hand."""
    scores: Mapping[str, Sequence[float]]
    """Of calibration scenes, by profile."""
    perception: Mapping[str, Any] | None
    trials: Sequence[Mapping[str, Any]] | None
    audit: Mapping[str, Any] | None = None


def read(sources: Sources) -> Inputs:
    """Read all that was named. Raises BadInput for what is missing or does not fit."""
    main = folder_of_results(sources.results)
    also = [folder_of_results(path) for path in sources.also]
    known = _parameters(main, sources.parameters)
    recordings = sources.recordings
    if recordings is not None:
        _check_recordings(main, recordings)
    return Inputs(
        study=main,
        injected=tuple(one for one in also if one.manifest.made_with.get("injected")),
        others=tuple(one for one in also if not one.manifest.made_with.get("injected")),
        facts=None if recordings is None else scene_facts.read(recordings, main.scenes),
        openings=() if recordings is None else tuple(ledger.read(recordings)),
        parameters=known,
        scores=_scores(known, sources.calibration),
        perception=None if sources.perception is None else _json(sources.perception),
        trials=None if sources.trials is None else _lines(sources.trials),
        audit=None if sources.audit is None else _json(sources.audit),
    )


def folder_of_results(folder: Path) -> Study:
    """One folder that `study evaluate` wrote. Raises BadInput."""
    found = manifest.read(folder)
    if found is None:
        raise BadInput(
            f"{folder} holds no results.\n"
            f"  Make some: surefetch study evaluate --recordings DIR --policies … --out {folder}"
        )
    return study(found, {label: results.read(folder, label) for label in found.policies})


def _parameters(one: Study, folder: Path | None) -> Mapping[str, Parameters] | None:
    """The parameters of the results; None where those at hand are others and none were named.

    Raises:
        BadInput: the named ones are others.
    """
    known = {profile: profile_parameters(profile, folder) for profile in PROFILES}
    hashes = {name: manifest.parameters_hash(of) for name, of in known.items()}
    if hashes == one.manifest.made_with.get("parameters"):
        return known
    if folder is not None:
        raise BadInput(f"the results were not made with the parameters in {folder}.")
    return None


def _check_recordings(one: Study, recordings: Path) -> None:
    there = recordings / manifest.NAME
    made = json.loads(there.read_text("utf-8")) if there.exists() else {}
    if made != one.manifest.made_with.get("recordings"):
        raise BadInput(
            f"the results were not made on the recordings in {recordings}.\n"
            f"  theirs: {one.manifest.made_with.get('recordings')}\n  these: {made}"
        )


def _scores(
    known: Mapping[str, Parameters] | None, calibration: Path | None
) -> Mapping[str, Sequence[float]]:
    if known is None or calibration is None:
        return {}
    cell = simulated_cell()
    return {
        profile: calibration_scores.scores(of, calibration, cell) for profile, of in known.items()
    }


def _json(path: Path) -> Mapping[str, Any]:
    try:
        return msgspec.json.decode(path.read_bytes(), type=dict[str, Any])
    except (OSError, msgspec.DecodeError) as error:
        raise BadInput(f"{path} cannot be read: {error}") from None


def _lines(path: Path) -> Sequence[Mapping[str, Any]]:
    try:
        return [msgspec.json.decode(line) for line in path.read_bytes().splitlines()]
    except (OSError, msgspec.DecodeError) as error:
        raise BadInput(f"{path} cannot be read: {error}") from None
