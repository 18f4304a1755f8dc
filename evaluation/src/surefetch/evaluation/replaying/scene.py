"""A recorded scene, ready to be replayed: what may be seen of it, apart from what is true of it."""

from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from surefetch.common.messages import Detection
from surefetch.evaluation.recordings.measured import Measured
from surefetch.evaluation.recordings.recording import Recording, RecordingTruth, Shot, State


@dataclass(frozen=True, eq=False)
class RecordedScene:
    """Detections are named anew, because recorded names say the family."""

    recording: Recording
    truth: RecordingTruth
    stratum: str
    measured: Measured | None
    """What came of the robot's attempts; None where nobody tried."""
    shots: Mapping[State, Shot]
    bodies: Mapping[str, str | None]
    """The body under each detection, by its new name. For the world and the scorer alone."""


def ready(
    recording: Recording,
    truth: RecordingTruth,
    stratum: str = "",
    measured: Measured | None = None,
) -> RecordedScene:
    """The scene with detections named ``SHOT-NUMBER``; the rest is the scorer's."""
    shots: dict[State, Shot] = {}
    bodies: dict[str, str | None] = {}
    for k, shot in enumerate(recording.shots):
        under = truth.bodies(shot.state)
        renamed: list[Detection] = []
        for n, detection in enumerate(shot.observations.detections):
            renamed.append(msgspec.structs.replace(detection, id=f"{k}-{n}"))
            bodies[f"{k}-{n}"] = under.get(detection.id)
        seen = msgspec.structs.replace(shot.observations, detections=tuple(renamed))
        shots[shot.state] = msgspec.structs.replace(shot, observations=seen)
    return RecordedScene(recording, truth, stratum, measured, shots, bodies)
