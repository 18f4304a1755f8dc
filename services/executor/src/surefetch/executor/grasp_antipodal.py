"""The built-in grasp proposer: antipodal pairs on the completed footprint, from above.

A grasp is thought of as a hand that comes along its approach, with a column over each finger, over
the palm and over the camera: whatever stands in a column says how deep the tips may go. So the
deepest place of every grasp is one minimum over points, and all grasps are judged at once.

Letters: n points, g grasps, s places along a finger's breadth. Tool frame of a grasp: x along the
fingers' breadth, y the closing direction, z the approach. Depths are along z, from the point where
the approach crosses half the object's height.
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
YAWS = 36
TILTS_RAD = tuple(np.radians([0.0, -15.0, 15.0, -30.0, 30.0]))
CLEARANCES = (1.0, 0.6)
"""Shares of the hand's clearance tried; the smaller one where there is little room."""
SIDE_M = 0.005
"""Kept free beside fingers and palm: collision checks grow them, and what is seen is uncertain."""
UNDER_TIP_M = 0.006
UNDER_PALM_M = 0.008
PAD_OVERLAP_MIN_M = 0.008
"""Height of the object that the pads must cover."""
LIFTED_SHARE = 0.35
LIFTED_M = 0.015
"""Tips stop this share of the height above the support, at most so high: low, not scraping."""
PLACES = np.linspace(-0.5, 0.5, 7)
KEPT = 24
APART_RAD = float(np.radians(12.0))


@dataclass(frozen=True, eq=False)
class _Target:
    footprint: Footprint
    low_m: float
    """World z where it stands"""
    height_m: float


@dataclass(frozen=True, eq=False)
class _Grasps:
    """g grasps thought of."""

    yaw_rad: Array
    tilt_rad: Array
    clearance_m: Array
    """(g,) on each side while approaching"""
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
        deepest, highest = _depth_limits(target, grasps, points_world_m[~mask], hand)
        room = deepest >= highest
        tried["access"] = int((~room).sum())
        if not room.any():
            why = f"no room beside the object for fingers and palm, {len(room)} ways tried"
            raise NoGrasp("access", why, tried)
        return _ranked(target, grasps[room], deepest[room], highest[room], hand)


def _too_wide(thought: _Grasps, hand: Hand) -> str:
    narrowest, limit = 1e3 * thought.width_m.min(), 1e3 * hand.object_width_max_m
    return f"the object is at least {narrowest:.0f} mm wide and the hand takes {limit:.0f} mm"


def _target(own: Array) -> _Target:
    low, top = (float(v) for v in np.quantile(own[:, 2], [0.01, 0.99]))
    low = max(low, 0.0)
    return _Target(footprint_of(own[:, :2]), low, max(top - low, 1e-3))


def _thought_of(target: _Target, hand: Hand) -> _Grasps:
    """Every angle, tilt and clearance, through the middle of the object."""
    grid = np.meshgrid(_yaws(target.footprint), TILTS_RAD, CLEARANCES, indexing="ij")
    yaw, tilt, share = (v.ravel() for v in grid)
    places = PLACES * hand.finger_breadth_m
    low, high = target.footprint.sides_m(yaw, np.broadcast_to(places, (len(yaw), len(places))))
    met = low < high
    first = np.where(met, low, np.inf).min(axis=1)
    last = np.where(met, high, -np.inf).max(axis=1)
    R = _rotations(yaw, tilt)
    middle = target.footprint.center_m + (first + last)[:, None] / 2.0 * R[:, :2, 1]
    level = np.full(len(yaw), target.low_m + target.height_m / 2.0)
    return _Grasps(
        yaw_rad=yaw,
        tilt_rad=tilt,
        clearance_m=share * hand.clearance_m,
        R=R,
        origin_m=np.column_stack([middle, level]),
        width_m=last - first,
        slant=_slant(low, high, met, places),
    )


def _yaws(footprint: Footprint) -> Array:
    """All around, and along the sides of the tightest rectangle."""
    even = 2.0 * np.pi * np.arange(2 * YAWS) / (2 * YAWS)
    fine = np.linspace(0.0, np.pi / 2.0, 90, endpoint=False)
    area = footprint.half_width_m(fine) * footprint.half_width_m(fine + np.pi / 2.0)
    return np.concatenate([even, fine[area.argmin()] + np.pi / 2.0 * np.arange(4)])


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
    depth: Array = (target.height_m / 2.0 - above_m - corner_m) / cos
    return depth


def _depth_limits(
    target: _Target, grasps: _Grasps, others: Array, hand: Hand
) -> tuple[Array, Array]:
    """Deepest and least deep (g,) place of the tips: room below, and hold on the object."""
    seen = np.einsum("gji,gnj->gni", grasps.R, others[None] - grasps.origin_m[:, None])
    reach = hand.tip_z_m(grasps.width_m)
    leaning = np.abs(np.sin(grasps.tilt_rad)) * target.footprint.half_width_m(grasps.yaw_rad)
    own_top = -target.height_m / 2.0 * np.cos(grasps.tilt_rad) - leaning
    limits = [
        _depth_of(target, grasps, UNDER_TIP_M, hand),
        _first_under_fingers(seen, grasps, hand) - UNDER_TIP_M,
        own_top + reach - hand.palms[0].face_z_m - UNDER_PALM_M,
        *(_first_under(seen, p) + reach - p.face_z_m - UNDER_PALM_M for p in hand.palms),
    ]
    highest = _depth_of(target, grasps, target.height_m - PAD_OVERLAP_MIN_M, hand)
    return np.min(limits, axis=0), highest


def _first_under_fingers(seen: Array, grasps: _Grasps, hand: Hand) -> Array:
    """Depth (g,) of the first point that a finger would meet on its way, closing included."""
    inner = grasps.width_m[:, None] / 2.0
    outer = inner + grasps.clearance_m[:, None] + hand.finger_thickness_m
    across = np.abs(seen[..., 1])
    met: NDArray[np.bool_] = np.abs(seen[..., 0]) < hand.finger_breadth_m / 2.0 + SIDE_M
    met &= (across > inner - SIDE_M) & (across < outer + SIDE_M)
    return _first(seen[..., 2], met)


def _first_under(seen: Array, palm: Palm) -> Array:
    """Depth (g,) of the first point in the palm's column."""
    off = np.abs(seen[..., :2] - palm.center_xy_m)
    return _first(seen[..., 2], (off < palm.half_xy_m + SIDE_M).all(axis=-1))


def _first(depth: Array, met: NDArray[np.bool_]) -> Array:
    first: Array = np.where(met, depth, np.inf).min(axis=1, initial=np.inf)
    return first


def _ranked(
    target: _Target, grasps: _Grasps, deepest: Array, highest: Array, hand: Hand
) -> tuple[GraspPose, ...]:
    lifted = min(LIFTED_SHARE * target.height_m, LIFTED_M)
    depth = np.clip(_depth_of(target, grasps, lifted, hand), highest, deepest)
    score = _scores(target, grasps, depth, hand)
    poses = []
    for i in _diverse(grasps, score):
        T = rigid(grasps.R[i], grasps.origin_m[i] + depth[i] * grasps.R[i, :, 2])
        width = float(grasps.width_m[i])
        open_width = width + 2.0 * float(grasps.clearance_m[i])
        poses.append(GraspPose(T, open_width, width, float(score[i])))
    return tuple(poses)


def _scores(target: _Target, grasps: _Grasps, depth: Array, hand: Hand) -> Array:
    """(g,) in (0, 1]: hold, upright approach, square touch, room to approach, narrow opening."""
    held_m = target.height_m / 2.0 + depth * np.cos(grasps.tilt_rad)
    hold = np.clip(held_m / min(target.height_m, 0.04), 0.05, 1.0)
    upright = np.cos(grasps.tilt_rad) ** 4
    square = 1.0 / (1.0 + (grasps.slant / 0.15) ** 2)
    room = grasps.clearance_m / hand.clearance_m
    narrow = 1.0 - 0.5 * grasps.width_m / hand.object_width_max_m
    score: Array = hold * upright * square * room * narrow
    return score


def _diverse(grasps: _Grasps, score: Array) -> list[int]:
    """Indices of the best grasps, none too like a better one."""
    kept: list[int] = []
    for i in np.argsort(-score, kind="stable"):
        turned = np.abs((grasps.yaw_rad[kept] - grasps.yaw_rad[i] + np.pi) % (2 * np.pi) - np.pi)
        alike = (turned < APART_RAD) & (grasps.tilt_rad[kept] == grasps.tilt_rad[i])
        if not alike.any():
            kept.append(int(i))
        if len(kept) == KEPT:
            break
    return kept
