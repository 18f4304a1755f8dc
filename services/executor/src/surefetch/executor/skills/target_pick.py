"""Which of the proposed grasps of a track the arm can carry out, and why not the others."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from surefetch.common.messages import Estimate, Track
from surefetch.executor.grasping.cloud import grasp_cloud
from surefetch.executor.grasping.ports import GraspPose, NoGrasp
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.obstacles import NamedBox
from surefetch.executor.skills.pick import Pick, Scenes, Way, farthest, plan_pick
from surefetch.executor.skills.situation import (
    Situation,
    Workcell,
    inside_container,
    solid_of,
    surroundings,
    track_of,
)

APPROACH_M = 0.08
ABOVE_M = 0.03
"""Kept between the fingertips and what they come down past, when the approach begins."""
LIFT_M = 0.12
LIFT_OVER_M = 0.08
"""Over the container's rim"""


@dataclass(frozen=True, eq=False)
class Tried:
    """How many proposals each check refused, and the refusal of the one that came farthest."""

    counts: dict[str, int]
    refusal: Infeasible | None


def plan_target(
    workcell: Workcell,
    now: Situation,
    track_id: int,
    around: CollisionScene,
    rng: np.random.Generator,
) -> tuple[Pick | None, Tried]:
    """The first proposed grasp, in rank order, that can be reached, closed and lifted.

    Args:
        workcell: The arm and the proposer.
        now: Where it stands and what was perceived.
        track_id: What to grasp.
        around: `surroundings` of now, shared between tracks.
        rng: For the path planner.
    """
    try:
        track = track_of(now.estimate, track_id)
        solid = solid_of(track)
        _check_access(now, track)
        points, mask = grasp_cloud(now.estimate, track)
        poses = workcell.proposer.propose(points, mask, workcell.hand)
    except NoGrasp as refusal:
        return None, Tried({str(k): n for k, n in refusal.tried.items() if n}, refusal)
    except Infeasible as refusal:
        return None, Tried({refusal.refusal: 1}, refusal)
    without = surroundings(workcell, now, without_track=track_id)
    ways = [_way(now.estimate, pose, track_id, solid) for pose in poses]
    pick, refusals = plan_pick(workcell, now, ways, Scenes(around, without), rng)
    counts = dict(Counter(str(refusal.refusal) for refusal in refusals))
    if pick is not None:
        return pick, Tried(counts, None)
    best = farthest(refusals)
    why = f"none of {len(refusals)} grasps can be done: {best.why}"
    return None, Tried(counts, Infeasible(best.refusal, why))


def _check_access(now: Situation, track: Track) -> None:
    if now.holding is not None:
        raise Infeasible("access", f"the hand still holds {now.holding.name}")
    center = np.asarray(track.center_world_m)
    if now.estimate.cover == "covered" and inside_container(now.estimate, center):
        raise Infeasible("access", f"track {track.id} is in the container and the lid is on")


def _way(estimate: Estimate, pose: GraspPose, track: int, solid: NamedBox) -> Way:
    """Down from above everything that the fingers come past, and up over the rim."""
    tip, axis = pose.T_world_tcp[:3, 3], pose.T_world_tcp[:3, 2]
    top = float(solid.T_world_box[2, 3] + solid.size_m[2] / 2.0)
    lift_m = LIFT_M
    if inside_container(estimate, solid.T_world_box[:3, 3]):
        assert estimate.container is not None
        rim = estimate.container.rim_z_m
        bottom = top - float(solid.size_m[2])
        top, lift_m = max(top, rim), max(lift_m, rim - bottom + LIFT_OVER_M)
    back_m = max(APPROACH_M, (top + ABOVE_M - float(tip[2])) / max(float(-axis[2]), 0.5))
    return Way(
        T_world_flange=pose.T_world_flange,
        open_width_m=pose.open_width_m,
        object_width_m=pose.object_width_m,
        back_m=back_m,
        lift_m=lift_m,
        taken=solid,
        track=track,
        touched=(solid.name,),
    )
