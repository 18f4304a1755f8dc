"""Taking something: approach above it, straight down, close, straight up; planned as one.

The way that is found keeps one branch of the arm from the approach's end to the lift's.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array, inverse, rigid
from surefetch.executor import kinematics, ur10e
from surefetch.executor.collision import HELD, TABLE, CollisionScene, Held
from surefetch.executor.infeasible import Infeasible
from surefetch.executor.motion import Tool
from surefetch.executor.obstacles import NamedBox
from surefetch.executor.situation import (
    Holding,
    Situation,
    Workcell,
    allowing_contacts,
    fingers_touching,
)
from surefetch.executor.steps import Step, line, raised

FIRST_LIFT_M = 0.05
"""After this the width is measured again."""
LOWER_LIFTS = (1.0, 0.6)
"""Shares of the wished height that are tried, where the arm cannot reach higher."""
STAGES = {"estimate": 0, "aperture": 1, "access": 2, "reach": 3, "limits": 4, "collision": 5}
"""How far a refused way came; `path` is the farthest."""


@dataclass(frozen=True, eq=False)
class Way:
    """One way to take a thing: where the hand closes, how wide, from how far, and what comes."""

    T_world_flange: Array
    """(4, 4) where the hand closes"""
    open_width_m: float
    object_width_m: float
    back_m: float
    """Length of the straight approach along the tool's axis"""
    lift_m: float
    taken: NamedBox
    """What is taken, in the world"""
    track: int | None
    touched: tuple[str, ...]
    """Obstacles that the fingers may touch: the thing itself"""


@dataclass(frozen=True, eq=False)
class Pick:
    """A way, with every motion."""

    way: Way
    approach: Step
    descend: Step
    lift: Step
    """The first 50 mm"""
    lift_on: Step
    holding: Holding
    """What will be in the hand"""

    @property
    def steps(self) -> tuple[Step, ...]:
        """All motions in order."""
        return self.approach, self.descend, self.lift, self.lift_on


def farthest(refusals: list[Infeasible]) -> Infeasible:
    """The refusal of the way that came farthest; of several the first."""
    return max(refusals, key=lambda refusal: STAGES.get(refusal.refusal, len(STAGES)))


def plan_pick(
    workcell: Workcell,
    now: Situation,
    way: Way,
    around: CollisionScene,
    without: CollisionScene,
    rng: np.random.Generator,
) -> Pick:
    """The motions of one way, in the first of the arm's branches that has them all.

    Args:
        workcell: The arm.
        now: Where it stands.
        way: What to do.
        around: Everything, the thing to take included.
        without: Everything but the thing to take.
        rng: For the path planner.

    Raises:
        Infeasible: the refusal of the branch that came farthest.
    """
    refusals: list[Infeasible] = []
    for q_pre in _before_it(way, now.q_rad):
        try:
            return _in_branch(workcell, now, way, q_pre, around, without, rng)
        except Infeasible as refusal:
            refusals.append(refusal)
            if refusal.refusal == "path":
                break
    raise farthest(refusals)


def _before_it(way: Way, near_rad: Array) -> Iterator[Array]:
    """Configurations at the approach's beginning, one for each branch, the nearest first."""
    T = way.T_world_flange @ rigid(np.eye(3), np.array([0.0, 0.0, -way.back_m]))
    seen: list[Array] = []
    for q in kinematics.solutions(T, near_rad):
        if all(np.abs(np.sin((q - other) / 2.0)).max() > 1e-6 for other in seen):
            seen.append(q)
            yield q


def _in_branch(
    workcell: Workcell,
    now: Situation,
    way: Way,
    q_pre: Array,
    around: CollisionScene,
    without: CollisionScene,
    rng: np.random.Generator,
) -> Pick:
    motion = workcell.motion
    open_hand = Tool(way.open_width_m, careful=False)
    near = around.allowing([pair for thing in way.touched for pair in fingers_touching(thing)])
    descend = line(motion, "descend", q_pre, way.T_world_flange, near, open_hand, slow_end=True)
    shut = near.in_collision(descend.end_rad, way.object_width_m)
    if shut is not None:
        raise Infeasible("collision", f"the closing {shut[0]} would touch the {shut[1]}")
    holding = Holding(
        way.taken.name,
        way.track,
        Held(inverse(way.T_world_flange) @ way.taken.T_world_box, way.taken.size_m),
        way.object_width_m,
        way.T_world_flange,
    )
    lift, lift_on = _lift(workcell, way, descend.end_rad, without, holding)
    to_it = motion.to_joints(now.q_rad, q_pre, around, open_hand, rng)
    approach = Step("approach", to_it, open_hand, around)
    return Pick(way, approach, descend, lift, lift_on, holding)


def _lift(
    workcell: Workcell, way: Way, q_rad: Array, without: CollisionScene, holding: Holding
) -> tuple[Step, Step]:
    """Straight up with the thing in the hand; at its place it may touch what it touches there."""
    motion, full_hand = workcell.motion, Tool(way.object_width_m, careful=True)
    scene = allowing_contacts(
        without.holding(holding.held).allowing([(HELD, TABLE)]), q_rad, way.object_width_m
    )
    first = raised(way.T_world_flange, FIRST_LIFT_M)
    lift = line(motion, "lift", q_rad, first, scene, full_hand)
    refusals: list[Infeasible] = []
    for share in LOWER_LIFTS:
        top = raised(way.T_world_flange, max(share * way.lift_m, FIRST_LIFT_M + 0.02))
        try:
            return lift, line(motion, "lift on", lift.end_rad, top, scene, full_hand)
        except Infeasible as refusal:
            refusals.append(refusal)
    raise refusals[0]


def opening_m(workcell: Workcell, width_m: float, room_m: float) -> float:
    """A finger opening this much wider than a thing, as far as the hand opens."""
    return min(width_m + room_m, workcell.hand.width_max_m)


def tip_z_m(T_world_flange: Array, width_m: float) -> float:
    """Height of the fingertips when the flange is at a pose."""
    return float((T_world_flange @ ur10e.tcp(width_m))[2, 3])
