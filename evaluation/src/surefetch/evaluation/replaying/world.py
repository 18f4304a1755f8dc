"""The table of a recorded scene, as far as it was recorded."""

from collections import Counter

from surefetch.common.cell import InformRow
from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Observations, Track
from surefetch.evaluation.recordings.recording import State, first_state
from surefetch.evaluation.replaying.outcomes import NO_BODY, Outcomes
from surefetch.evaluation.replaying.scene import RecordedScene


class OutOfRecording(SurefetchError):
    """An episode led to where the recording ends; it must be run live. Nothing is substituted."""


class RecordedWorld:
    """One episode's physical state: the cover, and which bodies were grasped at."""

    def __init__(self, scene: RecordedScene, outcomes: Outcomes) -> None:
        self._scene = scene
        self._outcomes = outcomes
        self._attempts: Counter[tuple[str, str]] = Counter()
        self._cover = first_state(scene.recording.covered).cover
        self.grasped_at: list[str] = []
        """Bodies that were grasped at, in order, those that slipped included."""

    def state(self, view: str) -> State:
        """Where the camera is, and what became of the cover."""
        return State(view=view, cover=self._cover)

    def see(self, view: str) -> Observations:
        """What was recorded from a view in the present state. Raises OutOfRecording."""
        state = self.state(view)
        if state not in self._scene.shots:
            raise OutOfRecording(
                f"{self._named()} was recorded without the view {view} with cover {state.cover}."
            )
        return self._scene.shots[state]

    def inform(self, row: InformRow) -> bool:
        """Try an information action. Raises OutOfRecording for removing what is not there."""
        if row.kind == "remove_cover" and self._cover != "closed":
            raise OutOfRecording(
                f"{self._named()}: {row.name} was tried where no cover is on, which was not "
                "recorded."
            )
        done = self._outcomes.informs(row, self._attempt(row.name, NO_BODY))
        if done and row.kind == "remove_cover":
            self._cover = "open"
        return done

    def grasp(self, track: Track) -> bool:
        """Try to grasp what lies under the latest detection of a track."""
        body = self._scene.bodies[track.last_detection]
        if body is not None:
            self.grasped_at.append(body)
        return self._outcomes.grasps(body, self._attempt("grasp", body or NO_BODY))

    def _attempt(self, action: str, body: str) -> int:
        self._attempts[action, body] += 1
        return self._attempts[action, body]

    def _named(self) -> str:
        return f"{self._scene.recording.family}:{self._scene.recording.seed}"
