"""The table of a scene, as an episode acts on it: what is seen, and what comes of an action."""

from dataclasses import dataclass
from typing import Protocol

from surefetch.common.cell import InformRow
from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Estimate, Feasibility, FrameInfo, Grasp, Observations
from surefetch.evaluation.recordings.free_space import FreeSpace
from surefetch.evaluation.recordings.recording import State
from surefetch.evaluation.replaying.beliefs import History
from surefetch.planner.episode_state import EpisodeState


class OutOfRecording(SurefetchError):
    """An episode led to where the recording ends; it must be run live. Nothing is substituted."""


class WorldFailed(SurefetchError):
    """What makes up a live table gave no answer, as a service that fails in mid-episode."""

    def __init__(self, error: SurefetchError) -> None:
        self.error = error
        super().__init__(str(error))


class ViewFailed(SurefetchError):
    """The camera does not get to where the next look is to be taken."""

    def __init__(self, view: str, why: str) -> None:
        self.view, self.why = view, why
        super().__init__(f"the camera could not be moved to the view {view}: {why}")


@dataclass(frozen=True, eq=False)
class Sight:
    """What one look shows."""

    state: State
    """The true one."""
    seen: Observations
    frame: FrameInfo
    free_space: FreeSpace
    take: int = 0
    """See `Heard.take`."""


@dataclass(frozen=True)
class Report:
    """What the executor says of an action."""

    done: bool
    injected: bool = False
    """The action was not tried; that it failed is only said."""
    body: str | None = None
    """What was grasped at, for the scorer alone."""
    duration_s: float = 0.0
    """Modelled."""
    why: str = ""
    """What was measured, in words."""


class World(Protocol):
    """One episode's table."""

    def see(self, view: str) -> Sight:
        """What is to be seen from a view now. Raises OutOfRecording, ViewFailed."""
        ...

    def feasible(self, history: History, estimate: Estimate) -> Feasibility:
        """What the robot could do after these looks. Raises OutOfRecording."""
        ...

    def inform(self, row: InformRow) -> Report:
        """Try an information action. Raises OutOfRecording."""
        ...

    def grasp(self, grasp: Grasp, state: EpisodeState) -> Report:
        """Try to grasp a track."""
        ...
