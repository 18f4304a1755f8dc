"""Table and floor in a picture, by intersecting each pixel's ray with the plane (pure).

The software renderer visits every pixel of a triangle's bounding box, so that two large rectangles
would cost it four times everything else together.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array


@dataclass(frozen=True)
class Sheet:
    """A level rectangle, seen from above."""

    z_m: float
    min_m: tuple[float, float]
    max_m: tuple[float, float]
    rgb: tuple[float, float, float]
    segment: int
    """What a segmentation calls its pixels."""


def sheet_depth(
    sheet: Sheet, T_world_camera: Array, K: Array, width: int, height: int
) -> NDArray[np.float32]:
    """Depth (h, w) along the optical axis in metres at which pixels hit the sheet; inf if not."""
    eye, R = T_world_camera[:3, 3], T_world_camera[:3, :3]
    across = np.outer(R[:, 0], (np.arange(width) - K[0, 2]) / K[0, 0])
    down = np.outer(R[:, 1], (np.arange(height) - K[1, 2]) / K[1, 1])
    ray = [across[k] + (down[k] + R[k, 2])[:, None] for k in range(3)]
    with np.errstate(divide="ignore"):
        depth_m = (sheet.z_m - eye[2]) / ray[2]
    hit = (depth_m > 0.0) & np.isfinite(depth_m) & (eye[2] > sheet.z_m)
    for k in range(2):
        along = eye[k] + depth_m * ray[k]
        hit &= (along >= sheet.min_m[k]) & (along <= sheet.max_m[k])
    return np.where(hit, depth_m, np.inf).astype(np.float32)
