"""The footprint of an object as a convex set, from noisy points: a support function per direction.

Letters: n points, k directions, g grasps, s places along a finger's breadth.
"""

from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array

DIRECTIONS = 72
_ANGLES = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
TRIM = 0.01
"""Share of the points that may lie beyond the footprint in any direction: noise."""
FINE_RAD = np.radians(np.linspace(-2.5, 2.5, 11))
_ALMOST_PARALLEL = 0.05


@dataclass(frozen=True, eq=False)
class Footprint:
    """All p with normal_k · p <= reach_k, about `center_m`."""

    center_m: Array
    """(2,) middle of the extents"""
    yaw_rad: float
    """Of the tightest rectangle around it: the first direction"""
    reach_m: Array
    """(k,) from the centre, along directions at equal angles from the yaw"""

    def half_width_m(self, angle_rad: Array) -> Array:
        """Half of the extent (g,) along directions at these angles (g,)."""
        step = (np.asarray(angle_rad) - self.yaw_rad) / (2.0 * np.pi) * DIRECTIONS
        around = np.arange(DIRECTIONS + 1)
        reach = np.concatenate([self.reach_m, self.reach_m[:1]])
        there = np.interp(step % DIRECTIONS, around, reach)
        opposite = np.interp((step + DIRECTIONS / 2) % DIRECTIONS, around, reach)
        half: Array = (there + opposite) / 2.0
        return half

    def sides_m(self, yaw_rad: Array, along_m: Array) -> tuple[Array, Array]:
        """Where lines parallel to a grasp's closing axis leave the footprint.

        Args:
            yaw_rad: (g,) angle of the grasp's x axis, seen from below: it closes along y.
            along_m: (g, s) places on x, from the centre.

        Returns:
            Lowest and highest y (g, s) of the footprint there; low > high outside it.
        """
        angles = self.yaw_rad + _ANGLES[None] - yaw_rad[:, None]
        normal_x, normal_y = np.cos(angles)[:, None], -np.sin(angles)[:, None]
        steep = np.abs(normal_y) > _ALMOST_PARALLEL
        y = (self.reach_m - normal_x * along_m[..., None]) / np.where(steep, normal_y, 1.0)
        high = np.where(steep & (normal_y > 0), y, np.inf).min(axis=2)
        low = np.where(steep & (normal_y < 0), y, -np.inf).max(axis=2)
        return low, high


def footprint_of(points_m: Array) -> Footprint:
    """The footprint of points (n, 2), a share of `TRIM` of them cut off in each direction."""
    middle = (points_m.min(axis=0) + points_m.max(axis=0)) / 2.0
    own = points_m - middle
    yaw = _square_yaw(own, _square_yaw(own, 0.0, _ANGLES[: DIRECTIONS // 4]), FINE_RAD)
    normals = _normals(yaw + _ANGLES)
    reach = _reach(own, normals)
    quarter = DIRECTIONS // 4
    opposite = reach - np.roll(reach, 2 * quarter)
    shift = (opposite[0] * normals[0] + opposite[quarter] * normals[quarter]) / 2.0
    return Footprint(middle + shift, yaw, reach - normals @ shift)


def _square_yaw(own: Array, about_rad: float, offsets_rad: Array) -> float:
    """The yaw, of those about one, of the rectangle around the points with the smallest area."""
    yaws = about_rad + offsets_rad
    sides = yaws + np.pi / 2.0 * np.arange(4)[:, None]
    reach = _reach(own, _normals(sides.ravel())).reshape(sides.shape)
    area = (reach[0] + reach[2]) * (reach[1] + reach[3])
    return float(yaws[area.argmin()])


def _normals(angles_rad: Array) -> Array:
    """Unit vectors (k, 2) at these angles."""
    return np.column_stack([np.cos(angles_rad), np.sin(angles_rad)])


def _reach(own: Array, normals: Array) -> Array:
    """How far the points go (k,), but for a share of TRIM of them."""
    along = normals @ own.T
    last = min(int((1.0 - TRIM) * len(own)), len(own) - 1)
    reach: Array = np.partition(along, last, axis=1)[:, last]
    return reach
