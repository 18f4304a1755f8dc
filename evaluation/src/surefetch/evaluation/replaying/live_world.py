"""The table of a scene in the simulator, with executor and perception in this very process.

It takes the place of a recording: to finish an episode that the recording does not hold to its
end, and to tell whether replayed episodes go as they would go live.
"""

from itertools import count
from typing import Final, TypeVar

from surefetch.common.cell import InformRow
from surefetch.common.errors import BadInput, SurefetchError
from surefetch.common.injections import Injector, kind_of_action
from surefetch.common.messages import (
    Estimate,
    Feasibility,
    Grasp,
    Inform,
    Look,
    Message,
    Outcome,
    Verb,
)
from surefetch.common.topics import FRAME, Topic
from surefetch.evaluation.recordings.bench import Bench
from surefetch.evaluation.recordings.desk import Desk
from surefetch.evaluation.recordings.free_space import FreeSpace, seen_in
from surefetch.evaluation.recordings.recording import Cover, State
from surefetch.evaluation.replaying.beliefs import EPISODE, History
from surefetch.evaluation.replaying.world import Report, Sight, ViewFailed, WorldFailed
from surefetch.evaluation.scenes.generate import GeneratedScene
from surefetch.perception.backends import BACKENDS
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.planner.account import Account, End
from surefetch.planner.crew import Crew
from surefetch.planner.episode_state import EpisodeState
from surefetch.planner.estimate import NOTHING_SEEN
from surefetch.planner.fetching import fetch
from surefetch.planner.situation import Errand

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)

BOOT: Final = "live"
FRAME_S: Final = 1.0


class LiveWorld(Bench):
    """One episode's table. `bodies` grows with every look, for the scorer alone."""

    def __init__(
        self,
        generated: GeneratedScene,
        errand: Errand,
        perception: str,
        injector: Injector,
    ) -> None:
        self.bodies: dict[str, str | None] = {}
        self._generated = generated
        self._errand = errand
        self._injector = injector
        self._desk = desk = Counter(BOOT)
        super().__init__(generated.scene, errand.cell, perception, desk)
        ids = count()
        self._crew = TimedCrew(
            desk,
            Account(desk, EPISODE),
            new_id=lambda: f"command {next(ids)}",
            cancelled=lambda: False,
        )
        self._n_looks = 0
        self._estimate = NOTHING_SEEN
        self._at_view = False

    def see(self, view: str) -> Sight:
        """Drive there if need be, capture and perceive. Raises ViewFailed."""
        self._drive(view)
        frame = self._crew.capture()
        seen = self._crew.observe(frame, self._errand.target, view)
        self.bodies |= self.bodies_under(seen)
        self._n_looks += 1
        pixels = self._desk.ask(FRAME, frame.frame, timeout_s=FRAME_S)
        space = FreeSpace.of(seen_in(pixels))
        return Sight(State(view=view, cover=self._cover()), seen, frame, space, self._n_looks)

    def feasible(self, history: History, estimate: Estimate) -> Feasibility:
        """What the executor says of all tracks and of what may be looked at."""
        self._estimate = estimate
        now = "covered" if history[-1].covered else "open"
        informs = tuple(row.name for row in self._errand.rows if row.requires == now)
        return self._crew.feasible(estimate, tuple(t.id for t in estimate.tracks), informs)

    def inform(self, row: InformRow) -> Report:
        """Carry out an information action."""
        if self._injector.strikes(kind_of_action(row)):
            self._at_view = False
            return Report(done=False, injected=True)
        return self.try_inform(row)

    def try_inform(self, row: InformRow) -> Report:
        """The same, never injected."""
        outcome = self._crew.execute(Inform(name=row.name), self._estimate)
        self._at_view = outcome.status == "done"
        return Report(self._at_view, duration_s=outcome.duration_s, why=outcome.why)

    def grasp(self, grasp: Grasp, state: EpisodeState) -> Report:
        """Grasp, lift and verify, as the planner has it done."""
        if self._injector.strikes("grasp"):
            self._at_view = False
            return Report(done=False, injected=True, body=self._under(grasp, state))
        return self.try_grasp(grasp, state)

    def try_grasp(self, grasp: Grasp, state: EpisodeState) -> Report:
        """The same, never injected."""
        self._at_view = False
        before, began_s = len(self.simulated.touched), self._crew.motion_s
        after = fetch(self._crew, self._errand, state, grasp, "")
        held = isinstance(after, End) and after.outcome == "grasped"
        touched = self.simulated.touched[before:]
        body = touched[-1] if touched else self.simulated.held() or self._under(grasp, state)
        why = after.because if isinstance(after, End) else ""
        took_s = self._crew.motion_s - began_s
        return Report(held, body=body, duration_s=took_s, why=why)

    def _under(self, grasp: Grasp, state: EpisodeState) -> str | None:
        """The body under the latest detection of a track."""
        track = next(t for t in state.estimate.tracks if t.id == grasp.track)
        return self.bodies.get(track.last_detection)

    def _drive(self, view: str) -> None:
        why = ""
        for _ in range(self._errand.policy.profile.tries):
            if self._at_view:
                break
            outcome = self._crew.execute(Look(view=view), self._estimate)
            self._at_view, why = outcome.status == "done", outcome.why
        if not self._at_view:
            raise ViewFailed(view, why)

    def _cover(self) -> Cover:
        container = self._generated.scene.container
        if container is None or not container.covered:
            return "none"
        return "closed" if self.simulated.covered() else "open"


class Counter(Desk):
    """A desk that tells what fails behind it from what a policy does wrong."""

    def ask(self, topic: Topic[Q, R], request: Q, *, timeout_s: float) -> R:
        """Answer at once. Raises WorldFailed."""
        try:
            return super().ask(topic, request, timeout_s=timeout_s)
        except WorldFailed:
            raise
        except SurefetchError as error:
            raise WorldFailed(error) from error


class TimedCrew(Crew):
    """A crew that also adds up the modelled time of all motions."""

    motion_s = 0.0

    def execute(self, verb: Verb, estimate: Estimate) -> Outcome:
        """Do this, once. See `Crew.execute`."""
        outcome = super().execute(verb, estimate)
        self.motion_s += outcome.duration_s
        return outcome


def perception_of(backend: str) -> str:
    """The name under which the perception with this identity is wired.

    Raises:
        BadInput: there is none.
    """
    for name, make in BACKENDS.items():
        if make(LatestGeometry()).name == backend:
            return name
    raise BadInput(f'there is no perception "{backend}" here; the recordings were made with it.')
