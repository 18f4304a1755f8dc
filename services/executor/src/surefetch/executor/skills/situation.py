"""What a plan starts from: the arm, the hand, what was perceived, and what it has moved itself.

Obstacles come from the estimate. What the executor itself has put down (a lid, an object) joins
them, because no camera may ever have looked there; and what the hand holds leaves them.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.geometry import Array, inverse, transform
from surefetch.common.messages import Estimate, Track
from surefetch.executor.grasping.ports import GraspProposer
from surefetch.executor.motion.collision import FINGERS, HELD, CollisionScene, Held, Pair
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.obstacles import NamedBox, Obstacles, named, obstacles_of, track_name
from surefetch.executor.motion.planner import MotionPlanner, Tool
from surefetch.executor.robot import ur10e
from surefetch.executor.robot.hand import Hand, rg6

LID = "lid"
SAME_PLACE_M = 0.06
"""A track this near to where something was put down is that thing."""


@dataclass(frozen=True, eq=False)
class Workcell:
    """What planning knows apart from what was perceived: the cell file, the arm and the hand."""

    cell: Cell
    motion: MotionPlanner
    proposer: GraspProposer
    hand: Hand
    T_flange_camera: Array

    @classmethod
    def of(cls, cell: Cell, proposer: GraspProposer) -> "Workcell":
        """The workcell of a cell file."""
        mount = ur10e.camera_mount(cell.camera)
        return cls(cell, MotionPlanner(cell), proposer, rg6(mount), mount)


@dataclass(frozen=True, eq=False)
class Holding:
    """What is in the hand, as it was perceived before it was taken."""

    name: str
    """`track N`, or `lid`"""
    track: int | None
    held: Held
    width_m: float
    """Between the pads when the grasp was verified"""
    T_world_flange: Array
    """(4, 4), the hand where it closed on it"""

    def box_at(self, T_world_flange: Array, name: str) -> NamedBox:
        """Its box in the world when the flange is here."""
        return NamedBox(name, T_world_flange @ self.held.T_flange_object, self.held.size_m)


@dataclass(frozen=True, eq=False)
class Memory:
    """What the executor remembers of its own doing from one command to the next."""

    holding: Holding | None = None
    placed: tuple[NamedBox, ...] = ()
    """What it has put down"""

    def put(self, *boxes: NamedBox) -> "Memory":
        """The hand is empty, and these stand somewhere."""
        return Memory(None, (*self.placed, *boxes))


@dataclass(frozen=True, eq=False)
class Situation:
    """One moment."""

    q_rad: Array
    """(6,)"""
    width_m: float
    estimate: Estimate
    memory: Memory = Memory()

    @property
    def holding(self) -> Holding | None:
        """What is in the hand."""
        return self.memory.holding

    def then(self, q_rad: Array, width_m: float, holding: Holding | None) -> "Situation":
        """A later moment of a plan."""
        return replace(
            self, q_rad=q_rad, width_m=width_m, memory=replace(self.memory, holding=holding)
        )

    def tool(self) -> Tool:
        """The hand as it is."""
        return Tool(self.width_m, careful=self.holding is not None)


def surroundings(
    workcell: Workcell, now: Situation, *, without_track: int | None = None, lid: bool = True
) -> CollisionScene:
    """Everything that the arm must not touch now, with what it holds.

    Args:
        workcell: The arm's camera mount.
        now: The estimate, and what was put down.
        without_track: A track that is left out, because it is, or will be, in the hand.
        lid: False leaves the lid out for the same reason.
    """
    held = now.holding.held if now.holding is not None else None
    in_hand = now.holding.track if now.holding is not None else None
    out = [track for track in (without_track, in_hand) if track is not None]
    lid = lid and not (now.holding is not None and now.holding.name == LID)
    seen = obstacles_of(now.estimate, ignore_tracks=out, lid=lid)
    placed = tuple(box for box in now.memory.placed if not _is_any(box, now.estimate.tracks, out))
    around = Obstacles((*seen.boxes, *placed), seen.voxels_world_m)
    return CollisionScene(workcell.T_flange_camera, around, held)


def _is_any(box: NamedBox, tracks: Iterable[Track], ids: Iterable[int]) -> bool:
    centers = [track.center_world_m for track in tracks if track.id in ids]
    return any(np.linalg.norm(box.T_world_box[:3, 3] - c) < SAME_PLACE_M for c in centers)


def track_of(estimate: Estimate, track: int) -> Track:
    """The estimate's track of this id. Raises Infeasible (estimate)."""
    for one in estimate.tracks:
        if one.id == track:
            return one
    raise Infeasible("estimate", f"the estimate holds no track {track}")


def solid_of(track: Track) -> NamedBox:
    """The track's box. Raises Infeasible (estimate) where too little of it was seen for one."""
    if track.solid is None:
        raise Infeasible("estimate", f"too little of track {track.id} was seen to know its extents")
    return named(track_name(track.id), track.solid)


def inside_container(estimate: Estimate, point_world_m: Array) -> bool:
    """Whether a point (3,) is above the container's inner floor."""
    if estimate.container is None:
        return False
    outer = named("container", estimate.container.outer)
    local = transform(inverse(outer.T_world_box), point_world_m[None])[0]
    half = np.asarray(estimate.container.inner_size_m) / 2.0
    return bool((np.abs(local[:2]) < half).all())


def fingers_touching(name: str) -> tuple[Pair, ...]:
    """The pairs of both fingers with an obstacle."""
    return tuple((finger, name) for finger in FINGERS)


def allowing_contacts(
    scene: CollisionScene, q_rad: Array, width_m: float, shapes: Iterable[str] = (HELD, *FINGERS)
) -> CollisionScene:
    """The scene in which these shapes may go on touching what they touch at a configuration (6,).

    Raises:
        Infeasible: collision, when another shape touches something there.
    """
    while (pair := scene.in_collision(q_rad, width_m)) is not None:
        if pair[0] not in shapes:
            raise Infeasible("collision", f"the {pair[0]} would touch the {pair[1]}")
        scene = scene.allowing([pair])
    return scene
