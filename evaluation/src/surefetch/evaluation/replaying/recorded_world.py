"""The table of a recorded scene, as far as it was recorded."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from surefetch.common.cell import InformRow
from surefetch.common.errors import BadInput
from surefetch.common.injections import Injector, kind_of_action
from surefetch.common.messages import (
    Estimate,
    Feasibility,
    FrameInfo,
    Grasp,
)
from surefetch.evaluation.recordings.measured import Attempt
from surefetch.evaluation.recordings.recording import Cover, FeasibleAfter, Shot, State, first_state
from surefetch.evaluation.replaying.beliefs import History
from surefetch.evaluation.replaying.outcomes import NO_BODY, NotMeasured, Outcome, Outcomes
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.world import OutOfRecording, Report, Sight
from surefetch.planner.episode_state import EpisodeState


@dataclass(frozen=True)
class Disturbed:
    """A failed attempt that moved bodies."""

    action: str
    body: str
    """`NO_BODY`, where it was the cover that was acted on."""
    attempt: int
    """At this action and body, counted from 1."""
    measured: Attempt


class RecordedWorld:
    """One episode's physical state: the cover, and how often what was tried."""

    def __init__(
        self,
        scene: RecordedScene,
        outcomes: Outcomes,
        injector: Injector,
        *,
        remembers: bool = True,
    ) -> None:
        """At its beginning.

        Args:
            scene: the recording.
            outcomes: what comes of actions.
            injector: which of them are only reported as failed.
            remembers: whether tracks outlast the look that showed them.
        """
        self._remembers = remembers
        self._now: FeasibleAfter | None = None
        self._scene = scene
        self._outcomes = outcomes
        self.injector = injector
        self._attempts: Counter[tuple[str, str]] = Counter()
        self.cover: Cover = first_state(scene.recording.covered).cover
        self.disturbed: Disturbed | None = None
        """The failure after which the recording no longer holds."""

    @property
    def bodies(self) -> Mapping[str, str | None]:
        """Under each recorded detection, for the scorer alone."""
        return self._scene.bodies

    def see(self, view: str) -> Sight:
        """What was recorded from a view in the present state.

        Raises:
            OutOfRecording: it was not recorded, or bodies have been moved since.
        """
        if self.disturbed is not None:
            raise OutOfRecording(
                f"{self._named()}: {self.disturbed.action} failed and moved what stands there; "
                "what is to be seen now was not recorded."
            )
        state = State(view=view, cover=self.cover)
        if state not in self._scene.shots:
            raise OutOfRecording(
                f"{self._named()} was recorded without the view {view} with cover {state.cover}."
            )
        shot = self._scene.shots[state]
        return Sight(state, shot.observations, _frame(shot), shot.free_space)

    def feasible(self, history: History, estimate: Estimate) -> Feasibility:  # noqa: ARG002
        """What the executor said after these looks. Raises OutOfRecording."""
        looks = [heard.state for heard in history]
        try:
            self._now = self._scene.recording.feasible_after(
                looks if self._remembers else looks[-1:]
            )
        except BadInput as error:
            raise OutOfRecording(str(error)) from None
        return self._now.feasibility

    def inform(self, row: InformRow) -> Report:
        """Try an information action. Raises OutOfRecording for removing what is not there."""
        if row.kind == "remove_cover" and self.cover != "closed":
            raise OutOfRecording(
                f"{self._named()}: {row.name} was tried where no cover is on, which was not "
                "recorded."
            )
        if self.injector.strikes(kind_of_action(row)):
            return Report(done=False, injected=True)
        outcome = self._came_of(row.name, NO_BODY, lambda n: self._outcomes.informs(row, n))
        if outcome.done and row.kind == "remove_cover":
            self.cover = "open"
        took_s = outcome.duration_s or self._recorded_s(lambda now: now.informs_s.get(row.name))
        return Report(outcome.done, duration_s=took_s, why=outcome.why)

    def grasp(self, grasp: Grasp, state: EpisodeState) -> Report:
        """Try to grasp what lies under the latest detection of a track."""
        track = next(t for t in state.estimate.tracks if t.id == grasp.track)
        report = self.grasp_body(self._scene.bodies[track.last_detection])
        if report.injected or report.duration_s:
            return report
        return replace(report, duration_s=self._recorded_s(lambda now: now.grasps_s.get(track.id)))

    def grasp_body(self, body: str | None) -> Report:
        """Try to grasp a body; None: what is no body."""
        if self.injector.strikes("grasp"):
            return Report(done=False, injected=True, body=body)
        outcome = self._came_of("grasp", body or NO_BODY, lambda n: self._outcomes.grasps(body, n))
        return Report(outcome.done, body=body, duration_s=outcome.duration_s, why=outcome.why)

    def _recorded_s(self, of: Callable[[FeasibleAfter], float | None]) -> float:
        """The modelled time of an action, as it was planned; 0 where it was not."""
        return 0.0 if self._now is None else of(self._now) or 0.0

    def _came_of(self, action: str, body: str, outcome_of: Callable[[int], Outcome]) -> Outcome:
        self._attempts[action, body] += 1
        attempt = self._attempts[action, body]
        try:
            outcome = outcome_of(attempt)
        except NotMeasured:
            raise OutOfRecording(
                f"{self._named()}: what comes of attempt {attempt} of {action} was not measured."
            ) from None
        if outcome.disturbance is not None:
            self.disturbed = Disturbed(action, body, attempt, outcome.disturbance)
        return outcome

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
