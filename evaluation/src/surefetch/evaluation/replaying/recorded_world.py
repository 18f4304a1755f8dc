"""The table of a recorded scene, as far as it was recorded."""

from collections import Counter

from surefetch.common.cell import InformRow
from surefetch.common.injections import Injector
from surefetch.common.messages import (
    Estimate,
    Feasibility,
    FrameInfo,
    Grasp,
    GraspVerdict,
)
from surefetch.evaluation.recordings.recording import Shot, State, first_state
from surefetch.evaluation.replaying.beliefs import History
from surefetch.evaluation.replaying.outcomes import NO_BODY, Outcomes
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.world import OutOfRecording, Report, Sight
from surefetch.planner.episode_state import EpisodeState


class RecordedWorld:
    """One episode's physical state: the cover, and how often what was tried."""

    def __init__(self, scene: RecordedScene, outcomes: Outcomes, injector: Injector) -> None:
        self._scene = scene
        self._outcomes = outcomes
        self._injector = injector
        self._attempts: Counter[tuple[str, str]] = Counter()
        self._cover = first_state(scene.recording.covered).cover

    def see(self, view: str) -> Sight:
        """What was recorded from a view in the present state. Raises OutOfRecording."""
        state = State(view=view, cover=self._cover)
        if state not in self._scene.shots:
            raise OutOfRecording(
                f"{self._named()} was recorded without the view {view} with cover {state.cover}."
            )
        shot = self._scene.shots[state]
        return Sight(state, shot.observations, _frame(shot), shot.free_space)

    def feasible(self, history: History, estimate: Estimate) -> Feasibility:  # noqa: ARG002
        """Everything."""
        return Feasibility(
            grasps=tuple(
                GraspVerdict(track=t.id, feasible=True, refusal=None, why="", tried={})
                for t in estimate.tracks
            ),
            informs=(),
            duration_s=0.0,
        )

    def inform(self, row: InformRow) -> Report:
        """Try an information action. Raises OutOfRecording for removing what is not there."""
        if row.kind == "remove_cover" and self._cover != "closed":
            raise OutOfRecording(
                f"{self._named()}: {row.name} was tried where no cover is on, which was not "
                "recorded."
            )
        if self._injector.strikes("cover" if row.kind == "remove_cover" else "view"):
            return Report(done=False, injected=True)
        done = self._outcomes.informs(row, self._attempt(row.name, NO_BODY))
        if done and row.kind == "remove_cover":
            self._cover = "open"
        return Report(done)

    def grasp(self, grasp: Grasp, state: EpisodeState) -> Report:
        """Try to grasp what lies under the latest detection of a track."""
        track = next(t for t in state.estimate.tracks if t.id == grasp.track)
        return self.grasp_body(self._scene.bodies[track.last_detection])

    def grasp_body(self, body: str | None) -> Report:
        """Try to grasp a body; None: what is no body."""
        if self._injector.strikes("grasp"):
            return Report(done=False, injected=True, body=body)
        return Report(
            self._outcomes.grasps(body, self._attempt("grasp", body or NO_BODY)), body=body
        )

    def _attempt(self, action: str, body: str) -> int:
        self._attempts[action, body] += 1
        return self._attempts[action, body]

    def _named(self) -> str:
        return f"{self._scene.recording.family}:{self._scene.recording.seed}"


def _frame(shot: Shot) -> FrameInfo:
    """What a shot tells of its frame; the size of the image is not recorded."""
    return FrameInfo(
        frame=shot.observations.frame,
        view=shot.state.view,
        width=0,
        height=0,
        K=shot.K,
        T_world_camera=shot.T_world_camera,
        captured_s=0.0,
    )
