"""A frame lifted: the world point of every pixel, above a level support. Pure."""

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.perception.support_plane import Plane, find_support, levelled

Floats = NDArray[np.float32]

FAR_M: Final = 3.0
PLANE_SAMPLES: Final = 4000
EDGE_M: Final = 0.010
"""Smoothing does not cross steps in depth of about this size."""


@dataclass(frozen=True, eq=False)
class Surface:
    """Everything that a frame's depth says, before anything is recognised.

    (h, w) are the frame's. Heights count from the support.
    """

    frame: RgbdFrame
    T_world_camera: Array
    """(4, 4) such that the support is level"""
    support_z_m: float
    depth_m: Floats
    """(h, w) smoothed; 0 where missing and not guessed from neighbours"""
    points_world_m: Floats
    """(h, w, 3)"""
    height_m: Floats
    """(h, w); -1 where missing"""
    valid: NDArray[np.bool_]
    """(h, w)"""
    measured: NDArray[np.bool_]
    """(h, w): the sensor itself gave this depth"""

    @property
    def eye_world_m(self) -> Array:
        """(3,) where the camera is."""
        return self.T_world_camera[:3, 3]


def lift(frame: RgbdFrame) -> Surface | None:
    """Find the support and lift every pixel. None when no support can be seen."""
    measured = np.isfinite(frame.depth_m) & (frame.depth_m > 0) & (frame.depth_m < FAR_M)
    depth_m = smoothed(filled(np.where(measured, frame.depth_m, np.float32(0)), frame.rgb))
    rays = rays_of(frame.K, *depth_m.shape)
    plane = _support(depth_m, measured, rays, frame.T_world_camera)
    if plane is None:
        return None
    T, support_z = levelled(plane, frame.T_world_camera)
    points = depth_m[..., None] * (rays @ T[:3, :3].T.astype(np.float32))
    points += T[:3, 3].astype(np.float32)
    valid = depth_m > 0
    height = np.where(valid, points[..., 2] - np.float32(support_z), np.float32(-1))
    return Surface(frame, T, support_z, depth_m, points, height, valid, measured)


def rays_of(K: Array, height: int, width: int) -> Floats:
    """(h, w, 3) direction of each pixel in the camera frame, with z = 1."""
    rays = np.ones((height, width, 3), dtype=np.float32)
    rays[..., 0] = ((np.arange(width) - K[0, 2]) / K[0, 0])[None, :]
    rays[..., 1] = ((np.arange(height) - K[1, 2]) / K[1, 1])[:, None]
    return rays


def smoothed(depth_m: Floats) -> Floats:
    """Depth with the sensor's noise averaged, steps kept, missing left missing."""
    return np.asarray(cv2.bilateralFilter(depth_m, 5, EDGE_M, 2.0), dtype=np.float32)


def filled(depth_m: Floats, rgb: NDArray[np.uint8]) -> Floats:
    """Missing pixels take the depth of the neighbour, up to two pixels away, most like in colour.

    Sensors lose depth at steps; colour tells to which side of the step a pixel belongs.
    """
    out = depth_m
    for _ in range(2):
        near = cv2.dilate((out > 0).astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
        rows, columns = np.nonzero((out == 0) & near)
        if len(rows) == 0:
            break
        out = _filled_once(out, rgb, rows, columns)
    return out


_NEIGHBOURS: Final = tuple(
    (dy, dx) for dy in (-2, -1, 0, 1, 2) for dx in (-2, -1, 0, 1, 2) if (dy, dx) != (0, 0)
)


def _filled_once(
    depth_m: Floats, rgb: NDArray[np.uint8], rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> Floats:
    h, w = depth_m.shape
    colors = rgb.astype(np.float32)
    own = colors[rows, columns]
    best_cost = np.full(len(rows), 200.0, dtype=np.float32)
    best_depth = np.zeros(len(rows), dtype=np.float32)
    for dy, dx in _NEIGHBOURS:
        r, c = np.clip(rows + dy, 0, h - 1), np.clip(columns + dx, 0, w - 1)
        depth = depth_m[r, c]
        cost = np.abs(colors[r, c] - own).sum(1) + 3.0 * (dy * dy + dx * dx) ** 0.5
        better = (depth > 0) & (cost < best_cost)
        best_cost = np.where(better, cost, best_cost)
        best_depth = np.where(better, depth, best_depth)
    out = depth_m.copy()
    out[rows, columns] = best_depth
    return out


def _support(
    depth_m: Floats, measured: NDArray[np.bool_], rays: Floats, T_world_camera: Array | None
) -> Plane | None:
    rows, columns = np.nonzero(measured & (depth_m > 0))
    step = max(1, len(rows) // PLANE_SAMPLES)
    rows, columns = rows[::step], columns[::step]
    points = (depth_m[rows, columns, None] * rays[rows, columns]).astype(np.float64)
    return find_support(points, T_world_camera)
