"""The footprint of an object as a convex set, from noisy points: a support function per direction.

Letters: n points, k directions, g grasps, s places along a finger's breadth.
"""

from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array

DIRECTIONS = 72
_ANGLES = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
_NORMALS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)])
TRIM = 0.01
"""Share of the points that may lie beyond the footprint in any direction: noise."""
_ALMOST_PARALLEL = 0.05


@dataclass(frozen=True, eq=False)
class Footprint:
    """All p with normal_k · p <= reach_k, about `center_m`."""

    center_m: Array
    """(2,) middle of the extents"""
    reach_m: Array
    """(k,) from the centre, along directions at equal angles"""

    def half_width_m(self, angle_rad: Array) -> Array:
        """Half of the extent (g,) along directions at these angles (g,)."""
        step = np.asarray(angle_rad) / (2.0 * np.pi) * DIRECTIONS
        reach = np.concatenate([self.reach_m, self.reach_m[:1]])
        both = [
            np.interp((step + d) % DIRECTIONS, np.arange(DIRECTIONS + 1), reach)
            for d in (0.0, DIRECTIONS / 2)
        ]
        half: Array = (both[0] + both[1]) / 2.0
        return half

    def sides_m(self, yaw_rad: Array, along_m: Array) -> tuple[Array, Array]:
        """Where lines parallel to a grasp's closing axis leave the footprint.

        Args:
            yaw_rad: (g,) angle of the grasp's x axis; it closes along y.
            along_m: (g, s) places on x, from the centre.

        Returns:
            Lowest and highest y (g, s) of the footprint there; low > high outside it.
        """
        turned = _ANGLES[None] - yaw_rad[:, None]
        normal_x, normal_y = np.cos(turned)[:, None], np.sin(turned)[:, None]
        steep = np.abs(normal_y) > _ALMOST_PARALLEL
        safe = np.where(steep, normal_y, 1.0)
        y = (self.reach_m - normal_x * along_m[..., None]) / safe
        high = np.where(steep & (normal_y > 0), y, np.inf).min(axis=2)
        low = np.where(steep & (normal_y < 0), y, -np.inf).max(axis=2)
        return low, high


def footprint_of(points_m: Array) -> Footprint:
    """The footprint of points (n, 2), a share of `TRIM` of them cut off in each direction."""
    middle = (points_m.min(axis=0) + points_m.max(axis=0)) / 2.0
    reach = np.quantile((points_m - middle) @ _NORMALS, 1.0 - TRIM, axis=0)
    quarter = DIRECTIONS // 4
    shift = np.array([reach[0] - reach[2 * quarter], reach[quarter] - reach[3 * quarter]]) / 2.0
    return Footprint(middle + shift, reach - shift @ _NORMALS)
