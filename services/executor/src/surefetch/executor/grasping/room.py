"""How deep a hand can go beside an object: what stands under its fingers, its palm, its camera.

A hand comes along its approach with a column over each finger, over the palm and over the camera.
Whatever stands in a column says how deep the tips may go, so the deepest place of every grasp is
one minimum over points, and all grasps are judged at once.

Letters: n points, g grasps, r kinds of room. Frames and depths as in `candidates`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.executor.grasping.candidates import Grasps, Target, depth_of
from surefetch.executor.robot.hand import Hand, Palm

SIDE_M = 0.005
"""Kept free beside fingers and palm: collision checks grow them, and what is seen is uncertain."""
UNDER_TIP_M = 0.006
UNDER_PALM_M = 0.008
NEAR_M, FAR_M = 0.14, 0.28
"""Fingers and palm come so near, the camera so far, from the middle of the object."""
HIGH_M = 0.02
"""The camera is farther above the fingertips than this, leaning included."""


@dataclass(frozen=True)
class Room:
    """How much room is wanted beside the object."""

    clearance_share: float
    """Of the hand's clearance, between pad and object while approaching"""
    side_m: float
    """Kept free beside the fingers"""
    worth: float
    """In (0, 1], for ranking: tight approaches bear less error"""


ROOMS = (
    Room(0.4, 0.8 * SIDE_M, 0.4),
    Room(0.7, SIDE_M, 0.7),
    Room(1.0, SIDE_M, 0.9),
    Room(1.4, 2.0 * SIDE_M, 1.0),
)
"""From tight to ample."""


def deepest_m(target: Target, grasps: Grasps, others_m: Array, hand: Hand) -> Array:
    """How deep the tips may go with each of ROOMS (r, g), past points (n, 3) of other things."""
    seen = _in_tool_frames(grasps, _in_reach(target, others_m))
    reach = hand.tip_z_m(grasps.width_m)
    limits = [
        depth_of(target, grasps, UNDER_TIP_M, hand),
        _own_top(target, grasps) + reach - hand.palms[0].face_z_m - UNDER_PALM_M,
    ]
    for palm in hand.palms:
        first = _first(seen[:, 2], _under_palm(seen, palm))
        limits.append(first + reach - palm.face_z_m - UNDER_PALM_M)
    whole_hand = np.min(limits, axis=0)
    fingers = [_first(seen[:, 2], _under_fingers(seen, grasps, hand, room)) for room in ROOMS]
    deepest: Array = np.minimum(whole_hand, np.array(fingers) - UNDER_TIP_M)
    return deepest


def _own_top(target: Target, grasps: Grasps) -> Array:
    """Depth (g,) of the object's highest corner."""
    leaning = np.abs(np.sin(grasps.tilt_rad)) * target.footprint.half_width_m(grasps.yaw_rad)
    top: Array = (target.axis_m - target.height_m) * np.cos(grasps.tilt_rad) - leaning
    return top


def _in_reach(target: Target, others_m: Array) -> Array:
    """The points that the hand could meet: near ones, and farther ones as high as the camera."""
    off = np.linalg.norm(others_m[:, :2] - target.footprint.center_m, axis=1)
    high = others_m[:, 2] > target.low_m + HIGH_M
    reached: Array = others_m[(off < NEAR_M) | (high & (off < FAR_M))]
    return reached


def _in_tool_frames(grasps: Grasps, points_m: Array) -> Array:
    """Points (n, 3) in every tool frame at its origin (g, 3, n)."""
    R = np.swapaxes(grasps.R, 1, 2)
    seen = (R.reshape(-1, 3) @ points_m.T).reshape(len(R), 3, -1)
    seen -= R @ grasps.origin_m[..., None]
    return seen


def _under_palm(seen: Array, palm: Palm) -> NDArray[np.bool_]:
    """Which points (g, n) are in the palm's column."""
    center, half = palm.center_xy_m, palm.half_xy_m + SIDE_M
    met: NDArray[np.bool_] = np.abs(seen[:, 0] - center[0]) < half[0]
    met &= np.abs(seen[:, 1] - center[1]) < half[1]
    return met


def _under_fingers(seen: Array, grasps: Grasps, hand: Hand, room: Room) -> NDArray[np.bool_]:
    """Which points (g, n) a finger would meet on its way, closing included."""
    inner = grasps.width_m[:, None] / 2.0
    outer = inner + room.clearance_share * hand.clearance_m + hand.finger_thickness_m
    across = np.abs(seen[:, 1])
    met: NDArray[np.bool_] = np.abs(seen[:, 0]) < hand.finger_breadth_m / 2.0 + room.side_m
    met &= (across > inner - room.side_m) & (across < outer + room.side_m)
    return met


def _first(depth: Array, met: NDArray[np.bool_]) -> Array:
    first: Array = np.where(met, depth, np.inf).min(axis=1, initial=np.inf)
    return first
