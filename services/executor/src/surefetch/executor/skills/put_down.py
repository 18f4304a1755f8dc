"""Putting down what is held: carry it level, straight down, open, straight up; planned as one."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array, inverse, rigid, rotation_z
from surefetch.executor.motion.collision import HELD, TABLE, CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.obstacles import NamedBox, Obstacles
from surefetch.executor.motion.planner import Tool
from surefetch.executor.robot import kinematics, ur10e
from surefetch.executor.skills.pick import farthest, opening_m
from surefetch.executor.skills.situation import (
    Holding,
    Situation,
    Workcell,
    allowing_contacts,
    fingers_touching,
    surroundings,
)
from surefetch.executor.skills.steps import Step, line, raised

GAP_M = 0.004
"""What is put down is let go this far above the table; it was perceived to a few millimetres."""
RELEASE_M = 0.03
"""How much wider the hand opens"""
RETREAT_M = 0.12
OVER_M = 0.10
"""Over the place, where a path that found no level way ends"""
RISES_M = (0.0, 0.08, 0.16)
"""How much higher a level way is tried"""


@dataclass(frozen=True, eq=False)
class PutDown:
    """All motions to put down what is held."""

    carry: tuple[Step, ...]
    lower: Step
    retreat: Step
    box: NamedBox
    """What stands there afterwards"""

    @property
    def steps(self) -> tuple[Step, ...]:
        """All motions in order."""
        return *self.carry, self.lower, self.retreat


def standing_at(
    holding: Holding, place_world_m: Sequence[float], yaws_rad: Sequence[float]
) -> list[Array]:
    """Flange poses that stand what is held, upright, at a place; one for each yaw of its box."""
    x, y, z = place_world_m
    center = np.array([x, y, z + float(holding.held.size_m[2]) / 2.0 + GAP_M])
    T_object_flange = inverse(holding.held.T_flange_object)
    return [rigid(rotation_z(yaw), center) @ T_object_flange for yaw in yaws_rad]


def plan_put_down(
    workcell: Workcell,
    now: Situation,
    places: Sequence[Array],
    name: str,
    rng: np.random.Generator,
    *,
    where_it_was: bool = False,
) -> PutDown:
    """The motions to the first of the places (flange poses) that can be reached.

    Args:
        workcell: The arm.
        now: What is held, and from where the arm starts.
        places: Flange poses (4, 4) at which the hand opens, in order of preference.
        name: How the thing is called from then on.
        rng: For the path planner.
        where_it_was: There it may touch what it touches at the place itself, as it did before.

    Raises:
        Infeasible: the refusal of the place that came farthest.
    """
    assert now.holding is not None, "only what is held can be put down"
    around = surroundings(workcell, now)
    refusals: list[Infeasible] = []
    for T_world_flange in places:
        try:
            return _to_place(workcell, now, T_world_flange, name, around, rng, where_it_was)
        except Infeasible as refusal:
            refusals.append(refusal)
    raise farthest(refusals)


def _to_place(
    workcell: Workcell,
    now: Situation,
    T_world_flange: Array,
    name: str,
    around: CollisionScene,
    rng: np.random.Generator,
    where_it_was: bool,
) -> PutDown:
    assert now.holding is not None
    hand = now.tool()
    down = around.allowing([(HELD, TABLE)])
    if not where_it_was:
        place = T_world_flange @ ur10e.tcp(hand.width_m)
        workcell.motion.configurations(place, now.q_rad, down, hand)
    else:
        q = kinematics.solutions(T_world_flange, now.q_rad)[0]
        down = allowing_contacts(down, q, hand.width_m)
    carry = _carry(workcell, now, T_world_flange, around, rng)
    lower = line(
        workcell.motion, "lower", carry[-1].end_rad, T_world_flange, down, hand, slow_end=True
    )
    box = now.holding.box_at(T_world_flange, name)
    return PutDown(carry, lower, _retreat(workcell, now, lower, box), box)


def _carry(
    workcell: Workcell,
    now: Situation,
    T_world_flange: Array,
    around: CollisionScene,
    rng: np.random.Generator,
) -> tuple[Step, ...]:
    """Level, at the height of now or a little higher; where that is not free, any way."""
    motion, hand = workcell.motion, now.tool()
    here = ur10e.flange(now.q_rad)
    for rise in RISES_M:
        up, over = raised(here, rise), T_world_flange.copy()
        over[2, 3] = max(up[2, 3], T_world_flange[2, 3])
        try:
            steps: tuple[Step, ...] = ()
            if rise > 0.0:
                steps = (line(motion, "rise", now.q_rad, up, around, hand),)
            start = steps[-1].end_rad if steps else now.q_rad
            return *steps, line(motion, "carry", start, over, around, hand)
        except Infeasible:
            continue
    over = raised(T_world_flange, OVER_M) @ ur10e.tcp(hand.width_m)
    trajectory = motion.to_pose(now.q_rad, over, around, hand, rng)
    return (Step("carry", trajectory, hand, around),)


def _retreat(workcell: Workcell, now: Situation, lower: Step, box: NamedBox) -> Step:
    """Straight up with the opened hand, away from what stands there now."""
    assert now.holding is not None
    empty = surroundings(workcell, now).holding(None)
    boxes = (*empty.obstacles.boxes, box)
    scene = CollisionScene(
        empty.T_flange_camera, Obstacles(boxes, empty.obstacles.voxels_world_m)
    ).allowing(fingers_touching(box.name))
    width = opening_m(workcell, now.width_m, RELEASE_M)
    tool = Tool(width)
    start = lower.end_rad
    scene = allowing_contacts(scene, start, width)
    up = raised(ur10e.flange(start), RETREAT_M)
    return line(workcell.motion, "retreat", start, up, scene, tool)
