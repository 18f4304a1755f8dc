"""The episode as the planner serves and publishes it."""

from typing import Literal

from surefetch.common.messages.action import Choice, Feasibility, Verb
from surefetch.common.messages.base import Message, Name, Text, Threshold
from surefetch.common.messages.frame import FrameId
from surefetch.common.messages.observation import CoverState, Target

EpisodeOutcome = Literal["grasped", "deferred", "failed", "stalled", "aborted", "stopped"]

AfterGrasp = Literal["deliver", "hold", "return"]


class Instruct(Message, frozen=True):
    """Fetch what this sentence names."""

    sentence: Text
    profile: Name
    policy: Name
    after_grasp: AfterGrasp = "deliver"


class Accepted(Message, frozen=True):
    """The sentence was understood and the episode has begun."""

    episode: Name
    target: Target
    understood: Text
    """The target in words: "a red cylinder with a stripe, inside the box"."""


class Equipped(Message, frozen=True):
    """What the episode decides with beside what it asks, so that its journal alone can tell why."""

    profile: Name
    policy: Name
    after_grasp: AfterGrasp
    parameters: Text
    """The parameter file, as JSON."""
    cell: Text
    """The cell file, as JSON."""


class Cancel(Message, frozen=True):
    """End this episode as stopped, after the motion under way."""

    episode: Name


class Captured(Message, frozen=True):
    """A frame was taken."""

    frame: FrameId
    view: str | None
    q: Name
    """The viewing condition to be expected, if the action before did what it was to do; what the
    frame shows, `Believed` tells."""


class Perceived(Message, frozen=True):
    """A frame was perceived."""

    frame: FrameId
    n_candidates: int
    container: bool
    cover: CoverState
    duration_s: float


class TrackSummary(Message, frozen=True):
    """A track as a person wants to see it."""

    id: int
    center_world_m: tuple[float, float, float]
    n_observations: int
    y0: str | None


class Believed(Message, frozen=True):
    """The belief after the step."""

    q: Name
    """The viewing condition of the look, as the frame verified it."""
    belief: dict[str, float]
    gamma: tuple[str, ...]
    tracks: tuple[TrackSummary, ...]
    counted: tuple[str, ...]
    """Observations that counted in this step, as track and y: "3 MI"."""


class QValue(Message, frozen=True):
    """The planner's cost of one admissible root action."""

    action: Name
    value: float
    track: int | None = None
    relation: str | None = None


class Decided(Message, frozen=True):
    """The decision with every Q value, and why in one plain sentence."""

    choice: Choice | None
    """None: nothing is admissible."""
    q_values: tuple[QValue, ...]
    because: Text
    feasibility: Feasibility
    duration_s: float


class Acting(Message, frozen=True):
    """A command was sent."""

    cmd_id: Name
    verb: Verb


class Acted(Message, frozen=True):
    """A command ended."""

    cmd_id: Name
    action: Name
    status: Name
    why: Text
    duration_s: float


class ActionRecord(Message, frozen=True):
    """One executed action in the result."""

    action: Name
    status: Name
    duration_s: float


class StepRecord(Message, frozen=True):
    """One step in the result."""

    q: Name
    observations: tuple[str, ...]
    """"track y" of each counted observation."""
    belief: dict[str, float]
    gamma: tuple[str, ...]
    q_values: tuple[QValue, ...]


class Ended(Message, frozen=True):
    """How the episode ended."""

    outcome: EpisodeOutcome
    reason: Name
    """Short and stable: `verified`, `no_view_left`, `absent`, `grasp_failed`, `step_limit` …"""
    because: Text
    """One plain sentence: what decided, the rival hypotheses, what could not be seen."""
    track: int | None
    relation: str | None
    delivered: bool | None
    actions: tuple[ActionRecord, ...]
    steps: tuple[StepRecord, ...]
    q_hat: Threshold
    durations: dict[str, float]
    """Wall seconds by service, and `motion`, the modelled time of the arm."""


Happening = Accepted | Equipped | Captured | Perceived | Believed | Decided | Acting | Acted | Ended


class Event(Message, frozen=True):
    """One thing that happened in an episode; `seq` has no gaps."""

    episode: Name
    seq: int
    step: int
    happening: Happening
