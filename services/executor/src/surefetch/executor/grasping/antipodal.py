"""The built-in grasp proposer: antipodal pairs on the completed footprint, mostly from above."""

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, rigid
from surefetch.common.messages import Refusal
from surefetch.executor.grasping.candidates import Grasps, Target, depth_of, grasps_of, target_of
from surefetch.executor.grasping.ports import GraspPose, NoGrasp
from surefetch.executor.grasping.room import ROOMS, deepest_m
from surefetch.executor.robot.hand import Hand

POINTS_MIN = 30
PAD_OVERLAP_MIN_M = 0.008
"""Height of the object that the pads must cover."""
LIFTED_SHARE, LIFTED_M = 0.35, 0.015
"""Tips stop this share of the height above the support, at most so high: low, not scraping."""
HELD_SHARE, HELD_M = 0.6, 0.04
"""Pads that cover this share of the height, a ball's equator included, or so much, hold well."""
SLANT_HALVES = 0.15
"""A slope of the touched sides that halves the worth of a grasp: corners turn in the hand."""
KEPT = 24
APART_RAD = float(np.radians(12.0))


class AntipodalProposer:
    """Thinks of all angles at once, drops what is too wide or has no room, ranks the rest.

    Keeps no state.
    """

    def propose(
        self, points_world_m: Array, mask: NDArray[np.bool_], hand: Hand
    ) -> tuple[GraspPose, ...]:
        """See `ports.GraspProposer`."""
        own = points_world_m[mask]
        if len(own) < POINTS_MIN:
            why = f"only {len(own)} points of the object are known; {POINTS_MIN} are needed"
            raise NoGrasp("estimate", why, {})
        target = target_of(own)
        thought = grasps_of(target, hand)
        fits = thought.width_m <= hand.object_width_max_m
        tried: dict[Refusal, int] = {"aperture": int((~fits).sum())}
        if not fits.any():
            raise NoGrasp("aperture", _too_wide(thought, hand), tried)
        grasps = thought[fits]
        deepest = deepest_m(target, grasps, points_world_m[~mask], hand)
        depth, score = _judged(target, grasps, deepest, hand)
        access: NDArray[np.bool_] = score.max(axis=0) > 0.0
        tried["access"] = int((~access).sum())
        if not access.any():
            why = f"no room beside the object for fingers and palm, {len(access)} ways tried"
            raise NoGrasp("access", why, tried)
        return _ranked(grasps, depth, score, hand)


def _too_wide(thought: Grasps, hand: Hand) -> str:
    narrowest, limit = 1e3 * thought.width_m.min(), 1e3 * hand.object_width_max_m
    return f"the object is at least {narrowest:.0f} mm wide and the hand takes {limit:.0f} mm"


def _judged(target: Target, grasps: Grasps, deepest: Array, hand: Hand) -> tuple[Array, Array]:
    """Depth and score (r, g) of every grasp with each of ROOMS; score 0 where there is no room."""
    highest = depth_of(target, grasps, target.height_m - PAD_OVERLAP_MIN_M, hand)
    lifted = depth_of(target, grasps, min(LIFTED_SHARE * target.height_m, LIFTED_M), hand)
    depth = np.minimum(np.maximum(lifted, highest), deepest)
    held_m = target.height_m - target.axis_m + depth * np.cos(grasps.tilt_rad)
    hold = np.clip(held_m / min(HELD_SHARE * target.height_m, HELD_M), 0.05, 1.0)
    upright = np.cos(grasps.tilt_rad) ** 4
    square = 1.0 / (1.0 + (grasps.slant / SLANT_HALVES) ** 2)
    narrow = 1.0 - 0.5 * grasps.width_m / hand.object_width_max_m
    room = np.array([room.worth for room in ROOMS])[:, None]
    score = np.where(deepest >= highest, hold * room * (upright * square * narrow), 0.0)
    return depth, score


def _ranked(grasps: Grasps, depth: Array, score: Array, hand: Hand) -> tuple[GraspPose, ...]:
    """The best grasps, each with the room that suits it best."""
    best = score.argmax(axis=0)
    poses = []
    for i in _diverse(grasps, score.max(axis=0)):
        T = rigid(grasps.R[i], grasps.origin_m[i] + depth[best[i], i] * grasps.R[i, :, 2])
        width, share = float(grasps.width_m[i]), ROOMS[best[i]].clearance_share
        opening = min(width + 2.0 * share * hand.clearance_m, hand.width_max_m)
        poses.append(GraspPose(T, opening, width, float(score[best[i], i])))
    return tuple(poses)


def _diverse(grasps: Grasps, score: Array) -> list[int]:
    """Indices of the best grasps, none too like a better one."""
    kept: list[int] = []
    for i in np.argsort(-score, kind="stable")[: int((score > 0.0).sum())]:
        turned = np.abs((grasps.yaw_rad[kept] - grasps.yaw_rad[i] + np.pi) % (2 * np.pi) - np.pi)
        alike = (turned < APART_RAD) & (grasps.tilt_rad[kept] == grasps.tilt_rad[i])
        if not alike.any():
            kept.append(int(i))
        if len(kept) == KEPT:
            break
    return kept
