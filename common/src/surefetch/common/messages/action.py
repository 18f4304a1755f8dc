"""From a decision to motion: estimates, feasibility, commands and outcomes."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from surefetch.common import arrays
from surefetch.common.hypotheses import Relation
from surefetch.common.messages.base import Message, Name, Text
from surefetch.common.messages.belief import Track
from surefetch.common.messages.observation import Box3d, ContainerReading, CoverState

Refusal = Literal["reach", "limits", "path", "collision", "aperture", "access", "estimate"]
"""Why the robot cannot: inverse kinematics, joint or workspace limits, no path, collision at the
pose, wider than the gripper opens, no room for the fingers, nothing perceived to act on."""


class Estimate(Message, frozen=True, eq=False):
    """The world as perceived: everything the executor may plan against, and nothing else."""

    tracks: tuple[Track, ...]
    container: ContainerReading | None
    cover: CoverState
    obstacles: tuple[Box3d, ...]
    obstacle_points_world_m: NDArray[np.float32]
    """(n, 3)"""

    def __post_init__(self) -> None:
        arrays.check("obstacle_points_world_m", self.obstacle_points_world_m, np.float32, (None, 3))


class Inform(Message, frozen=True):
    """An information action: a row of the cell file."""

    name: Name


class Grasp(Message, frozen=True):
    """Grasp and lift this track, believed to be the target in this relation."""

    track: int
    relation: Relation


class Defer(Message, frozen=True):
    """Abstain. Ends the episode, moves nothing."""


Choice = Inform | Grasp | Defer


class Look(Message, frozen=True):
    """Move the camera to a view to verify; not an information action."""

    view: Name


class Deliver(Message, frozen=True):
    """Put the held object down at a configured place, open, verify empty, go home."""

    place: Name


class PutBack(Message, frozen=True):
    """Put the held object down where it was lifted."""


Verb = Inform | Grasp | Look | Deliver | PutBack


class AskFeasible(Message, frozen=True, eq=False):
    """Which of these could the robot do now, against this estimate?"""

    episode: Name
    step: int
    estimate: Estimate
    grasps: tuple[int, ...]
    """Tracks to check."""
    informs: tuple[Name, ...]
    """Information actions to check."""


class GraspVerdict(Message, frozen=True):
    """Feasibility of grasping one track. `tried` counts proposals per refusal."""

    track: int
    feasible: bool
    refusal: Refusal | None
    why: Text
    tried: dict[str, int]


class InformVerdict(Message, frozen=True):
    """Feasibility of one information action."""

    name: Name
    feasible: bool
    refusal: Refusal | None
    why: Text


class Feasibility(Message, frozen=True):
    """The executor's answer; a command is checked again when it comes."""

    grasps: tuple[GraspVerdict, ...]
    informs: tuple[InformVerdict, ...]
    duration_s: float


class Command(Message, frozen=True, eq=False):
    """Do this once. A repeated cmd_id gets the stored outcome and moves nothing."""

    cmd_id: Name
    episode: Name
    step: int
    verb: Verb
    estimate: Estimate


class Motion(Message, frozen=True, eq=False):
    """What the arm did: joints over time, for journals and pictures."""

    label: Name
    times_s: NDArray[np.float64]
    """(n,) from the start of this motion"""
    q_rad: NDArray[np.float64]
    """(n, 6)"""
    gripper_width_m: NDArray[np.float64]
    """(n,)"""

    def __post_init__(self) -> None:
        n = len(self.times_s)
        arrays.check("times_s", self.times_s, np.float64, (None,))
        arrays.check("q_rad", self.q_rad, np.float64, (n, 6))
        arrays.check("gripper_width_m", self.gripper_width_m, np.float64, (n,))


class Outcome(Message, frozen=True, eq=False):
    """What came of a command. The physical state only; a fresh capture follows."""

    cmd_id: Name
    status: Literal["done", "failed", "refused", "stopped"]
    refusal: Refusal | None
    why: Text
    checks: dict[str, bool]
    """Named measurements that decided: `closed_on_object`, `width_kept`, `released_empty` …"""
    gripper_width_m: float
    holding: bool
    duration_s: float
    """Modelled time of the motions."""
    planning_s: float
    motions: tuple[Motion, ...]
