"""A scripted table, recorded: every state that can be reached, as scripted perception reads it."""

from dataclasses import replace
from pathlib import Path

import msgspec
from made_up_recording import all_feasible, made_with, shot
from scripted_table import CELL, ScriptedPerception, Table, parameters

from surefetch.common.hypotheses import Relation
from surefetch.common.messages import FrameId, Observations, Observe, Target
from surefetch.common.parameters import Parameters
from surefetch.evaluation.fitting.variants import VARIANTS
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.recordings.recording import (
    FORMAT,
    Recording,
    RecordingTruth,
    ShotTruth,
    State,
    states,
)
from surefetch.evaluation.scenes.truth import SceneTruth

RED = Target(noun="object", color="red")


def numbers(profile: str, q_hat: float = 0.9) -> Parameters:
    """The script's parameters, with the same threshold for every variant of the belief."""
    full = parameters(profile, q_hat)
    calibrations = dict.fromkeys(VARIANTS, full.calibration())
    return msgspec.structs.replace(full, calibrations=calibrations)


def record(
    table: Table,
    *,
    wanted: int | None,
    target: Target = RED,
    family: str = "partial",
    seed: int = 100_000,
) -> tuple[Recording, RecordingTruth]:
    """What a recording of this table would hold; `wanted` is the target's place in its things."""
    reached = states(bool(table.covered), CELL)
    seen = [_see(table, state, counter) for counter, state in enumerate(reached)]
    shots = tuple(shot(state, one) for state, (one, _) in zip(reached, seen, strict=True))
    recording = Recording(
        format=FORMAT,
        family=family,
        seed=seed,
        made_with=made_with(),
        sentence="the red object",
        target=target,
        covered=bool(table.covered),
        shots=shots,
        feasible=all_feasible(shots, covered=bool(table.covered)),
        repeated=None,
        durations_s={},
    )
    truth = RecordingTruth(
        format=FORMAT,
        family=family,
        seed=seed,
        target=None if wanted is None else body(wanted),
        relation=None if wanted is None else _relation(table, wanted),
        graspable=(),
        matches={},
        shots=tuple(
            ShotTruth(state=state, bodies=bodies)
            for state, (_, bodies) in zip(reached, seen, strict=True)
        ),
    )
    return recording, truth


def save(folder: Path, recording: Recording, truth: RecordingTruth) -> None:
    """Write a recording as `surefetch study record` would."""
    scene = SceneTruth(
        family=recording.family,
        seed=recording.seed,
        generator_version=1,
        attempts=1,
        rejected={},
        stratum="",
        target=truth.target,
        relation=truth.relation,
        near_misses=(),
        twins=(),
        too_wide=(),
        sightings=(),
        evidence={},
    )
    recording_store.save(folder, recording, truth, scene)


def body(index: int) -> str:
    """The name of a thing."""
    return f"body {index}"


def _relation(table: Table, index: int) -> Relation:
    return "inside" if table.things[index].inside else "outside"


def _see(table: Table, state: State, counter: int) -> tuple[Observations, dict[str, str | None]]:
    covered = table.covered if state.cover != "open" else False
    now = replace(table, covered=covered, frames={counter: state.view})
    ask = Observe(
        episode="recorded", step=0, frame=FrameId(boot="partial", counter=counter), target=RED
    )
    bodies: dict[str, str | None] = {
        f"{counter}-{n}": body(table.things.index(seen))
        for n, seen in enumerate(now.visible(state.view))
    }
    return ScriptedPerception(now).observe(ask), bodies
