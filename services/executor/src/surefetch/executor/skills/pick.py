"""Taking something: approach above it, straight down, close, straight up; planned as one.

The way that is found keeps one branch of the arm from the approach's end to the lift's.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array, inverse, rigid
from surefetch.executor.motion.collision import HELD, TABLE, CollisionScene, Held
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.obstacles import NamedBox
from surefetch.executor.motion.planner import Tool
from surefetch.executor.robot import kinematics
from surefetch.executor.skills.situation import (
    Holding,
    Situation,
    Workcell,
    allowing_contacts,
    fingers_touching,
)
from surefetch.executor.skills.steps import Step, line, raised

FIRST_LIFT_M = 0.05
"""After this the width is measured again."""
SEARCHED = 2
"""Ways for which a path is searched; where these have none, the others will have none either."""
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


@dataclass(frozen=True, eq=False)
class Scenes:
    """What may not be touched: everything, and everything but the thing to take."""

    around: CollisionScene
    without: CollisionScene


def plan_pick(
    workcell: Workcell,
    now: Situation,
    ways: Sequence[Way],
    scenes: Scenes,
    rng: np.random.Generator,
) -> tuple[Pick | None, list[Infeasible]]:
    """The first of the ways that can be gone, and why those before it cannot.

    First with a straight joint move to where the approach begins, in the nearest of the arm's
    branches that has one; where no way has that, the first ones whose rest is free get a path
    search.
    """
    refusals: list[Infeasible] = []
    no_straight_move: list[Way] = []
    for way in ways:
        try:
            return _directly(workcell, now, way, scenes), refusals
        except Infeasible as refusal:
            refusals.append(refusal)
            if refusal.refusal == "path":
                no_straight_move.append(way)
    for way in no_straight_move[:SEARCHED]:
        try:
            return _by_search(workcell, now, way, scenes, rng), refusals
        except Infeasible as refusal:
            refusals[ways.index(way)] = refusal
    return None, refusals


def _directly(workcell: Workcell, now: Situation, way: Way, scenes: Scenes) -> Pick:
    refusals: list[Infeasible] = []
    for q_pre in _before_it(way, now.q_rad):
        try:
            approach = _approach(workcell, now, way, q_pre[None], scenes, None)
            return _pick(way, approach, _taking(workcell, way, q_pre, scenes))
        except Infeasible as refusal:
            refusals.append(refusal)
    raise farthest(refusals)


def _by_search(
    workcell: Workcell, now: Situation, way: Way, scenes: Scenes, rng: np.random.Generator
) -> Pick:
    """A path to whichever branch can be reached, of those in which the rest is free."""
    takings: list[_Taking] = []
    refusals: list[Infeasible] = []
    for q_pre in _before_it(way, now.q_rad):
        try:
            takings.append(_taking(workcell, way, q_pre, scenes))
        except Infeasible as refusal:
            refusals.append(refusal)
    if not takings:
        raise farthest(refusals)
    starts = np.array([taking.descend.start_rad for taking in takings])
    approach = _approach(workcell, now, way, starts, scenes, rng)
    reached = np.abs(starts - approach.end_rad).max(axis=1).argmin()
    return _pick(way, approach, takings[reached])


def _before_it(way: Way, near_rad: Array) -> Iterator[Array]:
    """Configurations at the approach's beginning, one for each branch, the nearest first."""
    T = way.T_world_flange @ rigid(np.eye(3), np.array([0.0, 0.0, -way.back_m]))
    seen: list[Array] = []
    for q in kinematics.solutions(T, near_rad):
        if all(np.abs(np.sin((q - other) / 2.0)).max() > 1e-6 for other in seen):
            seen.append(q)
            yield q


def _approach(
    workcell: Workcell,
    now: Situation,
    way: Way,
    goals_rad: Array,
    scenes: Scenes,
    rng: np.random.Generator | None,
) -> Step:
    tool = Tool(way.open_width_m)
    to_it = workcell.motion.to_joints(now.q_rad, goals_rad, scenes.around, tool, rng)
    return Step("approach", to_it, tool, scenes.around)


@dataclass(frozen=True, eq=False)
class _Taking:
    """The motions after the approach, in one branch."""

    descend: Step
    lift: Step
    lift_on: Step
    holding: Holding


def _pick(way: Way, approach: Step, rest: _Taking) -> Pick:
    return Pick(way, approach, rest.descend, rest.lift, rest.lift_on, rest.holding)


def _taking(workcell: Workcell, way: Way, q_pre: Array, scenes: Scenes) -> _Taking:
    """Down, shut and up from one configuration; the hand alone may touch the thing."""
    tool = Tool(way.open_width_m)
    near = scenes.around.allowing(
        [pair for thing in way.touched for pair in fingers_touching(thing)]
    )
    descend = line(workcell.motion, "descend", q_pre, way.T_world_flange, near, tool, slow_end=True)
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
    lift, lift_on = _lift(workcell, way, descend.end_rad, scenes.without, holding)
    return _Taking(descend, lift, lift_on, holding)


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
