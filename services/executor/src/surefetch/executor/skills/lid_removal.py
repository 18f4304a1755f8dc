"""Taking the lid off: by its knob, up, over everything that was seen, down beside the scene."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import inverse, rigid, rotation_z
from surefetch.common.messages import Box3d, ContainerReading
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.obstacles import NamedBox, named
from surefetch.executor.robot import ur10e
from surefetch.executor.skills.pick import Pick, Scenes, Way, farthest, opening_m, plan_pick
from surefetch.executor.skills.put_down import PutDown, plan_put_down, standing_at
from surefetch.executor.skills.situation import LID, Situation, Workcell, surroundings
from surefetch.executor.skills.steps import Step

KNOB_ROOM_M = 0.04
"""How much wider than the knob the hand comes down"""
KNOB_DEPTH_M = 0.022
"""How far the fingertips come below the knob's top"""
KNOB_FOOT_M = 0.004
"""At least so far above the plate"""
KNOB_MIN_M = 0.010
KNOB_M = 0.04
"""A cube in which the knob of a lid that was set down is for sure"""
OVER_ALL_M = 0.05
LIFT_MIN_M = 0.10
APPROACH_M = 0.10
TURNS_RAD = tuple(np.radians([0.0, 90.0, 45.0, 135.0, 180.0, 270.0, 225.0, 315.0]))
"""Of the hand about the knob, against the plate"""
SAME_FOOTPRINT_RAD = (0.0, np.pi)
OTHER_FOOTPRINT_RAD = (np.pi / 2.0, -np.pi / 2.0)
DOWN = np.diag([1.0, -1.0, -1.0])
PLACED_LID = "lid set down"


@dataclass(frozen=True, eq=False)
class LidRemoval:
    """All motions to take the lid off and set it down."""

    pick: Pick
    put_down: PutDown

    @property
    def steps(self) -> tuple[Step, ...]:
        """All motions in order."""
        return *self.pick.steps, *self.put_down.steps


def plan_lid_removal(
    workcell: Workcell, now: Situation, around: CollisionScene, rng: np.random.Generator
) -> LidRemoval:
    """The motions for the first turn of the hand about the knob that has them all.

    Raises:
        Infeasible: estimate (no lid, or no knob, was seen), access (the hand is full), else the
            refusal of the turn that came farthest.
    """
    container = now.estimate.container
    if container is None or container.lid is None:
        raise Infeasible("estimate", "no lid was seen")
    if container.lid.knob is None:
        raise Infeasible("estimate", "the lid's knob was not seen")
    if now.holding is not None:
        raise Infeasible("access", f"the hand still holds {now.holding.name}")
    without = surroundings(workcell, now, lid=False)
    scenes = Scenes(around, without)
    refusals: list[Infeasible] = []
    for way in _ways(workcell, container, container.lid.knob, without):
        pick, refused = plan_pick(workcell, now, [way], scenes, rng)
        refusals += refused
        if pick is None:
            continue
        try:
            return LidRemoval(pick, _set_down(workcell, now, pick, rng))
        except Infeasible as refusal:
            refusals.append(refusal)
    raise farthest(refusals)


def _ways(
    workcell: Workcell, container: ContainerReading, knob: Box3d, without: CollisionScene
) -> Iterator[Way]:
    """The hand straight down over the knob, in several turns."""
    assert container.lid is not None
    plate = named(LID, container.lid.plate)
    x, y, z = knob.center_world_m
    top, foot = z + knob.size_m[2] / 2.0, z - knob.size_m[2] / 2.0
    if top - foot < KNOB_MIN_M:
        raise Infeasible("estimate", f"the knob seems {1e3 * (top - foot):.0f} mm high: too low")
    tip_z = max(top - KNOB_DEPTH_M, foot + KNOB_FOOT_M)
    width = min(knob.size_m[:2])
    lift_m = max(LIFT_MIN_M, _highest_m(without) + OVER_ALL_M - float(plate.T_world_box[2, 3]))
    for turn in TURNS_RAD:
        R = rotation_z(container.lid.plate.yaw_rad + turn) @ DOWN
        yield Way(
            T_world_flange=rigid(R, np.array([x, y, tip_z])) @ inverse(ur10e.tcp(width)),
            open_width_m=opening_m(workcell, width, KNOB_ROOM_M),
            object_width_m=width,
            back_m=APPROACH_M,
            lift_m=lift_m,
            taken=plate,
            track=None,
            touched=("lid knob", LID),
        )


def _highest_m(around: CollisionScene) -> float:
    """The top of everything seen."""
    boxes = around.obstacles.boxes
    tops = [float(box.T_world_box[2, 3] + box.size_m[2] / 2.0) for box in boxes]
    return max([*tops, *around.obstacles.voxels_world_m[:, 2]], default=0.0)


def _set_down(workcell: Workcell, now: Situation, pick: Pick, rng: np.random.Generator) -> PutDown:
    after = now.then(pick.lift_on.end_rad, pick.way.object_width_m, pick.holding)
    place = workcell.cell.lid_place
    yaws = [np.radians(place.yaw_deg) + t for t in (*SAME_FOOTPRINT_RAD, *OTHER_FOOTPRINT_RAD)]
    places = standing_at(pick.holding, place.position_m, yaws)
    return plan_put_down(workcell, after, places, PLACED_LID, rng)


def knob_of(removal: LidRemoval) -> NamedBox:
    """The knob of the lid where it lies afterwards."""
    plate = removal.put_down.box
    size = np.full(3, KNOB_M)
    up = rigid(np.eye(3), np.array([0.0, 0.0, float(plate.size_m[2] + KNOB_M) / 2.0]))
    return NamedBox(f"{PLACED_LID}: knob", plate.T_world_box @ up, size)
