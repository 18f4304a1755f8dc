"""Which ground is taken: discs and turned rectangles on the table; what the views show (pure).

Lengths in metres, in the world's x and y.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.geometry import Array, intrinsics, inverse, project, transform
from surefetch.common.messages import CameraSpec
from surefetch.common.viewpoint import camera_pose

AREA_MIN_M = np.array([0.75, -0.30])
AREA_MAX_M = np.array([1.15, 0.30])
"""Where things stand."""
BORDER_PX = 6.0


@dataclass(frozen=True)
class Rectangle:
    """A turned rectangle on the table: centre, full lengths along its own axes, yaw."""

    x_m: float
    y_m: float
    size_m: tuple[float, float]
    yaw_rad: float

    def local(self, xy_m: Array) -> Array:
        """A point (2,) in the rectangle's own axes."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        dx, dy = xy_m[0] - self.x_m, xy_m[1] - self.y_m
        return np.array([c * dx + s * dy, c * dy - s * dx])

    def world(self, local_m: Array) -> Array:
        """Points (n, 2) in the rectangle's own axes, in the world."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        turned: Array = local_m @ np.array([[c, s], [-s, c]]) + [self.x_m, self.y_m]
        return turned

    def corners(self) -> Array:
        """(4, 2)."""
        half = np.asarray(self.size_m) / 2.0
        return self.world(half * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]))

    def distance_m(self, xy_m: Array) -> float:
        """From a point to the rectangle; 0 inside."""
        beyond = np.maximum(np.abs(self.local(xy_m)) - np.asarray(self.size_m) / 2.0, 0.0)
        return float(np.hypot(*beyond))


@dataclass
class Ground:
    """What stands where while a table is laid out."""

    discs: list[tuple[float, float, float]] = field(default_factory=list)
    """x, y, radius"""
    rectangles: list[Rectangle] = field(default_factory=list)

    def free(self, xy_m: Array, radius_m: float, gap_m: float) -> bool:
        """Whether a disc keeps the gap to everything and stays in the area."""
        if (xy_m < AREA_MIN_M).any() or (xy_m > AREA_MAX_M).any():
            return False
        near = radius_m + gap_m
        return all(np.hypot(xy_m[0] - x, xy_m[1] - y) > near + r for x, y, r in self.discs) and all(
            one.distance_m(xy_m) > near for one in self.rectangles
        )

    def free_rectangle(self, one: Rectangle, gap_m: float) -> bool:
        """Whether a rectangle keeps the gap to all discs and rectangles."""
        if any(one.distance_m(np.array([x, y])) <= r + gap_m for x, y, r in self.discs):
            return False
        return all(apart_m(one, other) > gap_m for other in self.rectangles)

    def take(self, xy_m: Array, radius_m: float) -> None:
        """A disc stands here now."""
        self.discs.append((float(xy_m[0]), float(xy_m[1]), radius_m))


def apart_m(a: Rectangle, b: Rectangle) -> float:
    """A lower bound of the distance between two rectangles, 0 when they may touch.

    Source: the separating axis theorem; the largest gap over the four edge directions.
    """
    gaps = []
    for yaw in (a.yaw_rad, a.yaw_rad + np.pi / 2, b.yaw_rad, b.yaw_rad + np.pi / 2):
        axis = np.array([np.cos(yaw), np.sin(yaw)])
        p, q = a.corners() @ axis, b.corners() @ axis
        gaps.append(max(float(q.min() - p.max()), float(p.min() - q.max())))
    return max(0.0, *gaps)


@dataclass(frozen=True, eq=False)
class Views:
    """The cell's cameras as they should stand, without their errors."""

    T_world_camera: dict[str, Array]
    """(4, 4) by name"""
    K: Array
    width: int
    height: int

    @classmethod
    def of(cls, cell: Cell, camera: CameraSpec) -> "Views":
        """The views of a cell, seen with this camera."""
        K = intrinsics(camera.width, camera.height, camera.vertical_fov_deg)
        poses = {view.name: camera_pose(cell, view) for view in cell.views}
        return cls(poses, K, camera.width, camera.height)

    def eye_m(self, view: str) -> Array:
        """(3,)."""
        return self.T_world_camera[view][:3, 3]

    def show(self, points_m: Array, names: Sequence[str] | None = None) -> bool:
        """Whether all points (n, 3) are in the images of these views, of all by default."""
        for name in self.T_world_camera if names is None else names:
            local = transform(inverse(self.T_world_camera[name]), points_m)
            if (local[:, 2] < 0.05).any():
                return False
            u, v = project(self.K, local).T
            if min(u.min(), v.min()) < BORDER_PX:
                return False
            if u.max() > self.width - 1 - BORDER_PX or v.max() > self.height - 1 - BORDER_PX:
                return False
        return True


def box_corners(one: Rectangle, low_m: float, high_m: float) -> Array:
    """The eight corners (8, 3) of an upright box over a rectangle."""
    xy = one.corners()
    return np.concatenate([np.column_stack([xy, np.full(4, z)]) for z in (low_m, high_m)])
