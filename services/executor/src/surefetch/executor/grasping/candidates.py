"""Every grasp thought of for an object: angles and tilts through its middle, antipodal sides.

Letters: g grasps, s places along a finger's breadth. Tool frame of a grasp: x along the fingers'
breadth, y the closing direction, z the approach. Depths are along z, from where the approach
crosses the object's axis: amid the height that pads cover.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.executor.grasping.footprint import Footprint, footprint_of
from surefetch.executor.robot.hand import Hand

EVEN_YAWS = 72
TILTED_YAWS = 24
TILTS_RAD = tuple(np.radians([-15.0, 15.0, -30.0, 30.0]))
PLACES = np.linspace(-0.5, 0.5, 7)
AXIS_SHARE = 0.65
"""Of the object's height, where an approach crosses its axis: amid what the pads cover."""


@dataclass(frozen=True, eq=False)
class Target:
    """The object to grasp, as an upright column."""

    footprint: Footprint
    low_m: float
    """World z where it stands"""
    height_m: float

    @property
    def axis_m(self) -> float:
        """Height above the support where approaches cross the middle."""
        return AXIS_SHARE * self.height_m


@dataclass(frozen=True, eq=False)
class Grasps:
    """g grasps, as columns."""

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

    def __getitem__(self, kept: NDArray[np.bool_]) -> "Grasps":
        return Grasps(*(getattr(self, field.name)[kept] for field in fields(self)))

    def __len__(self) -> int:
        return len(self.yaw_rad)


def target_of(own_m: Array) -> Target:
    """The column around the points (n, 3) of an object, without their noise."""
    low, top = (float(v) for v in np.quantile(own_m[:, 2], [0.01, 0.99]))
    low = max(low, 0.0)
    return Target(footprint_of(own_m[:, :2]), low, max(top - low, 1e-3))


def grasps_of(target: Target, hand: Hand) -> Grasps:
    """Every angle and tilt, closing on the middle of what is between the pads."""
    yaw, tilt = _angles(target.footprint)
    places = PLACES * hand.finger_breadth_m
    low, high = target.footprint.sides_m(yaw, np.broadcast_to(places, (len(yaw), len(places))))
    met = low < high
    first = np.where(met, low, np.inf).min(axis=1)
    last = np.where(met, high, -np.inf).max(axis=1)
    R = _rotations(yaw, tilt)
    middle = target.footprint.center_m + (first + last)[:, None] / 2.0 * R[:, :2, 1]
    level = np.full(len(yaw), target.low_m + target.axis_m)
    return Grasps(
        yaw_rad=yaw,
        tilt_rad=tilt,
        R=R,
        origin_m=np.column_stack([middle, level]),
        width_m=last - first,
        slant=_slant(low, high, met, places),
    )


def depth_of(target: Target, grasps: Grasps, above_m: float, hand: Hand) -> Array:
    """Depth (g,) at which the lowest corner of the tips is this far above the support."""
    cos, sin = np.cos(grasps.tilt_rad), np.abs(np.sin(grasps.tilt_rad))
    corner_m = hand.finger_breadth_m / 2.0 * sin
    depth: Array = (target.axis_m - above_m - corner_m) / cos
    return depth


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
