"""The built-in grasp proposer: antipodal pairs on the completed footprint, from above.

A grasp is thought of as a hand that comes along its approach, with a column over each finger, over
the palm and over the camera: whatever stands in a column says how deep the tips may go. So the
deepest place of every grasp is one minimum over points, and all grasps are judged at once.

Letters: n points, g grasps, s places along a finger's breadth. Tool frame of a grasp: x along the
fingers' breadth, y the closing direction, z the approach. Depths are along z, from where the
approach crosses the object's axis: amid the height that pads cover.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, rigid
from surefetch.common.messages import Refusal
from surefetch.executor.grasp_footprint import Footprint, footprint_of
from surefetch.executor.grasps import GraspPose, NoGrasp
from surefetch.executor.hand import Hand, Palm

POINTS_MIN = 30
EVEN_YAWS = 72
TILTED_YAWS = 24
TILTS_RAD = tuple(np.radians([-15.0, 15.0, -30.0, 30.0]))
SIDE_M = 0.005
"""Kept free beside fingers and palm: collision checks grow them, and what is seen is uncertain."""
ROOMS = ((0.4, 0.8 * SIDE_M), (0.7, SIDE_M), (1.0, SIDE_M), (1.4, 2.0 * SIDE_M))
"""How much room there may be beside the object, from tight to ample: share of the hand's clearance
between pad and object while approaching, and what is free beside the fingers."""
UNDER_TIP_M = 0.006
UNDER_PALM_M = 0.008
AXIS_SHARE = 0.65
"""Of the object's height, where an approach crosses its axis: amid what the pads cover."""
PAD_OVERLAP_MIN_M = 0.008
"""Height of the object that the pads must cover."""
LIFTED_SHARE = 0.35
LIFTED_M = 0.015
"""Tips stop this share of the height above the support, at most so high: low, not scraping."""
NEAR_M, FAR_M = 0.14, 0.28
"""Fingers and palm come so near, the camera so far, from the middle of the object"""
HIGH_M = 0.02
"""The camera is farther above the fingertips than this, leaning included."""
PLACES = np.linspace(-0.5, 0.5, 7)
KEPT = 24
APART_RAD = float(np.radians(12.0))


@dataclass(frozen=True, eq=False)
class _Target:
    footprint: Footprint
    low_m: float
    """World z where it stands"""
    height_m: float

    @property
    def axis_m(self) -> float:
        """Height above the support where approaches cross the middle."""
        return AXIS_SHARE * self.height_m


@dataclass(frozen=True, eq=False)
class _Grasps:
    """g grasps thought of."""

    yaw_rad: Array
    tilt_rad: Array
    R: Array
    """(g, 3, 3) tool in the world"""
    origin_m: Array
    """(g, 3) where depths count from"""
    width_m: Array
    """(g,) between the pads when closed"""
    slant: Array
    """(g,) slope of the touched sides against the pads"""

    def __getitem__(self, kept: NDArray[np.bool_]) -> "_Grasps":
        return _Grasps(*(getattr(self, field.name)[kept] for field in fields(self)))

    def __len__(self) -> int:
        return len(self.yaw_rad)


class AntipodalProposer:
    """See the module. Keeps no state."""

    def propose(
        self, points_world_m: Array, mask: NDArray[np.bool_], hand: Hand
    ) -> tuple[GraspPose, ...]:
        """See `grasps.GraspProposer`."""
        own = points_world_m[mask]
        if len(own) < POINTS_MIN:
            why = f"only {len(own)} points of the object are known; {POINTS_MIN} are needed"
            raise NoGrasp("estimate", why, {})
        target = _target(own)
        thought = _thought_of(target, hand)
        fits = thought.width_m <= hand.object_width_max_m
        tried: dict[Refusal, int] = {"aperture": int((~fits).sum())}
        if not fits.any():
            raise NoGrasp("aperture", _too_wide(thought, hand), tried)
        grasps = thought[fits]
        others = _in_reach(target, points_world_m[~mask])
        deepest, highest = _depth_limits(target, grasps, others, hand)
        room = (deepest >= highest).sum(axis=0)
        tried["access"] = int((room == 0).sum())
        if not room.any():
            why = f"no room beside the object for fingers and palm, {len(room)} ways tried"
            raise NoGrasp("access", why, tried)
        return _ranked(target, grasps, room, deepest, highest, hand)


def _too_wide(thought: _Grasps, hand: Hand) -> str:
    narrowest, limit = 1e3 * thought.width_m.min(), 1e3 * hand.object_width_max_m
    return f"the object is at least {narrowest:.0f} mm wide and the hand takes {limit:.0f} mm"


def _target(own: Array) -> _Target:
    low, top = (float(v) for v in np.quantile(own[:, 2], [0.01, 0.99]))
    low = max(low, 0.0)
    return _Target(footprint_of(own[:, :2]), low, max(top - low, 1e-3))


def _in_reach(target: _Target, others: Array) -> Array:
    """The points that the hand could meet: near ones, and farther ones as high as the camera."""
    off = np.linalg.norm(others[:, :2] - target.footprint.center_m, axis=1)
    high = others[:, 2] > target.low_m + HIGH_M
    reached: Array = others[(off < NEAR_M) | (high & (off < FAR_M))]
    return reached


def _thought_of(target: _Target, hand: Hand) -> _Grasps:
    """Every angle and tilt, through the middle of the object."""
    yaw, tilt = _angles(target.footprint)
    places = PLACES * hand.finger_breadth_m
    low, high = target.footprint.sides_m(yaw, np.broadcast_to(places, (len(yaw), len(places))))
    met = low < high
    first = np.where(met, low, np.inf).min(axis=1)
    last = np.where(met, high, -np.inf).max(axis=1)
    R = _rotations(yaw, tilt)
    middle = target.footprint.center_m + (first + last)[:, None] / 2.0 * R[:, :2, 1]
    level = np.full(len(yaw), target.low_m + target.axis_m)
    return _Grasps(
        yaw_rad=yaw,
        tilt_rad=tilt,
        R=R,
        origin_m=np.column_stack([middle, level]),
        width_m=last - first,
        slant=_slant(low, high, met, places),
    )


def _angles(footprint: Footprint) -> tuple[Array, Array]:
    """Yaws and tilts (g,): all around, and along the sides of the tightest rectangle."""
    square = footprint.yaw_rad + np.pi / 2.0 * np.arange(4)
    upright, tilted = (
        np.concatenate([square, 2.0 * np.pi * np.arange(n) / n]) for n in (EVEN_YAWS, TILTED_YAWS)
    )
    yaw = np.concatenate([upright, np.tile(tilted, len(TILTS_RAD))])
    tilt = np.concatenate([np.zeros(len(upright)), np.repeat(TILTS_RAD, len(tilted))])
    return yaw, tilt


def _rotations(yaw_rad: Array, tilt_rad: Array) -> Array:
    """Tool axes (g, 3, 3): x at the yaw, z down, then leaning along x by the tilt."""
    c, s, ct, st = np.cos(yaw_rad), np.sin(yaw_rad), np.cos(tilt_rad), np.sin(tilt_rad)
    x = np.stack([ct * c, ct * s, st], axis=1)
    y = np.stack([s, -c, np.zeros_like(c)], axis=1)
    return np.stack([x, y, np.cross(x, y)], axis=2)


def _slant(low: Array, high: Array, met: NDArray[np.bool_], places_m: Array) -> Array:
    """The steeper of the mean slopes of both touched sides against the pads (g,)."""
    slopes = [np.abs(np.where(met, side, 0.0) @ places_m) for side in (low, high)]
    steeper: Array = np.maximum(*slopes) / (places_m @ places_m)
    return steeper


def _depth_of(target: _Target, grasps: _Grasps, above_m: float, hand: Hand) -> Array:
    """Depth (g,) at which the lowest corner of the tips is this far above the support."""
    cos, sin = np.cos(grasps.tilt_rad), np.abs(np.sin(grasps.tilt_rad))
    corner_m = hand.finger_breadth_m / 2.0 * sin
    depth: Array = (target.axis_m - above_m - corner_m) / cos
    return depth


def _depth_limits(
    target: _Target, grasps: _Grasps, others: Array, hand: Hand
) -> tuple[Array, Array]:
    """How deep the tips may go, for each of ROOMS (r, g), and must go to hold the object (g,)."""
    reach = hand.tip_z_m(grasps.width_m)
    leaning = np.abs(np.sin(grasps.tilt_rad)) * target.footprint.half_width_m(grasps.yaw_rad)
    own_top = (target.axis_m - target.height_m) * np.cos(grasps.tilt_rad) - leaning
    whole = [
        _depth_of(target, grasps, UNDER_TIP_M, hand),
        own_top + reach - hand.palms[0].face_z_m - UNDER_PALM_M,
    ]
    seen = _in_tool_frames(grasps, others)
    for palm in hand.palms:
        first = _first(seen[:, 2], _in_column(seen, palm))
        whole.append(first + reach - palm.face_z_m - UNDER_PALM_M)
    fingers = [_first_under_fingers(seen, grasps, hand, *room) - UNDER_TIP_M for room in ROOMS]
    highest = _depth_of(target, grasps, target.height_m - PAD_OVERLAP_MIN_M, hand)
    return np.minimum(np.min(whole, axis=0), fingers), highest


def _in_tool_frames(grasps: _Grasps, points_world_m: Array) -> Array:
    """Points (n, 3) in every tool frame at its origin (g, 3, n)."""
    R = np.swapaxes(grasps.R, 1, 2)
    seen = (R.reshape(-1, 3) @ points_world_m.T).reshape(len(R), 3, -1)
    seen -= R @ grasps.origin_m[..., None]
    return seen


def _in_column(seen: Array, palm: Palm) -> NDArray[np.bool_]:
    """Which points (g, n) are in the palm's column."""
    center, half = palm.center_xy_m, palm.half_xy_m + SIDE_M
    met: NDArray[np.bool_] = np.abs(seen[:, 0] - center[0]) < half[0]
    met &= np.abs(seen[:, 1] - center[1]) < half[1]
    return met


def _first_under_fingers(
    seen: Array, grasps: _Grasps, hand: Hand, share: float, side_m: float
) -> Array:
    """Depth (g,) of the first point that a finger would meet on its way, closing included."""
    inner = grasps.width_m[:, None] / 2.0
    outer = inner + share * hand.clearance_m + hand.finger_thickness_m
    across = np.abs(seen[:, 1])
    met: NDArray[np.bool_] = np.abs(seen[:, 0]) < hand.finger_breadth_m / 2.0 + side_m
    met &= (across > inner - side_m) & (across < outer + side_m)
    return _first(seen[:, 2], met)


def _first(depth: Array, met: NDArray[np.bool_]) -> Array:
    first: Array = np.where(met, depth, np.inf).min(axis=1, initial=np.inf)
    return first


def _ranked(
    target: _Target,
    grasps: _Grasps,
    room: NDArray[np.int64],
    deepest: Array,
    highest: Array,
    hand: Hand,
) -> tuple[GraspPose, ...]:
    """The best of the grasps that have one or more of ROOMS."""
    lifted = _depth_of(target, grasps, min(LIFTED_SHARE * target.height_m, LIFTED_M), hand)
    used = deepest[np.maximum(room - 1, 0), np.arange(len(grasps))]
    depth = np.minimum(np.maximum(lifted, highest), used)
    score = np.where(room > 0, _scores(target, grasps, room, depth, hand), 0.0)
    poses = []
    for i in _diverse(grasps, score):
        T = rigid(grasps.R[i], grasps.origin_m[i] + depth[i] * grasps.R[i, :, 2])
        width, share = float(grasps.width_m[i]), ROOMS[room[i] - 1][0]
        opening = min(width + 2.0 * share * hand.clearance_m, hand.width_max_m)
        poses.append(GraspPose(T, opening, width, float(score[i])))
    return tuple(poses)


def _scores(
    target: _Target, grasps: _Grasps, room: NDArray[np.int64], depth: Array, hand: Hand
) -> Array:
    """(g,) in (0, 1]: hold, upright approach, square touch, room to approach, narrow opening."""
    held_m = target.height_m - target.axis_m + depth * np.cos(grasps.tilt_rad)
    hold = np.clip(held_m / min(target.height_m, 0.04), 0.05, 1.0)
    upright = np.cos(grasps.tilt_rad) ** 4
    square = 1.0 / (1.0 + (grasps.slant / 0.15) ** 2)
    narrow = 1.0 - 0.5 * grasps.width_m / hand.object_width_max_m
    score: Array = hold * upright * square * room / len(ROOMS) * narrow
    return score


def _diverse(grasps: _Grasps, score: Array) -> list[int]:
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
