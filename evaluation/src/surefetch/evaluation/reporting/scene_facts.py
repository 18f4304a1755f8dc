"""What the scorer knows of the scenes that were played; read after the fact, for the report."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.recordings.measured import Measured
from surefetch.evaluation.recordings.recording import RecordingTruth
from surefetch.evaluation.reporting.causes import Known
from surefetch.evaluation.scenes.truth import SceneTruth

Address = tuple[str, int]


@dataclass(frozen=True, eq=False)
class Facts:
    """Of one scene."""

    scene: SceneTruth
    recording: RecordingTruth
    measured: Measured | None

    @property
    def occlusion(self) -> float | None:
        """Share of the target that the first look does not show; None: no target."""
        if self.scene.target is None:
            return None
        shown = [
            sighting.share
            for sighting in self.scene.sightings
            if (sighting.body, sighting.view) == (self.scene.target, "center")
            and sighting.cover != "open"
        ]
        return 1.0 - shown[0] if shown else None

    @property
    def known(self) -> Known:
        """What the cause of a failure is told by."""
        shown: dict[tuple[str, str], float] = {
            (sighting.view, sighting.cover): sighting.share
            for sighting in self.scene.sightings
            if sighting.body == self.scene.target
        }
        return Known(self.recording.relation, shown, self.recording.matches)


def read(recordings: Path, scenes: Iterable[Address]) -> Mapping[Address, Facts]:
    """The facts of these scenes. Raises BadInput for one that is missing or damaged."""
    return {
        (family, seed): Facts(
            recording_store.load_scene_truth(recordings, family, seed),
            recording_store.load_truth(recordings, family, seed),
            recording_store.load_measured(recordings, family, seed)
            if recording_store.is_measured(recordings, family, seed)
            else None,
        )
        for family, seed in scenes
    }
