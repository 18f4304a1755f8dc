"""What is in the way but neither candidate nor container: screens, the unexplained. Pure."""

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.mask import Bits
from surefetch.common.messages import Box3d
from surefetch.perception import plates
from surefetch.perception.candidate import SceneView
from surefetch.perception.foreground import FAR_M, Foreground
from surefetch.perception.surface import Floats, Surface

MIN_PX: Final = 60
MIN_HEIGHT_M: Final = 0.010
MIN_SIZE_M: Final = 0.006
MAX_PLATES: Final = 4
MIN_PLATE_SHARE: Final = 0.04
THIN_TO_M: Final = 0.006
_SAMPLES: Final = 800


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Boxes for planning, and points for collision checks."""

    boxes: tuple[Box3d, ...]
    points_world_m: Floats
    """(n, 3), one a cube of 6 mm, of everything above the support"""


def find(scene: SceneView, foreground: Foreground) -> Obstacles:
    """Boxes around what nothing else explains, and all that stands on the support as points."""
    surface = scene.surface
    left = foreground.sure.copy()
    for candidate in scene.candidates:
        left &= ~candidate.bits
    if scene.container is not None:
        left &= ~scene.container.mask
    cleaned = cv2.morphologyEx(left.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
    n, labels, stats, _ = cv2.connectedComponentsWithStats(cleaned, connectivity=8)
    boxes: list[Box3d] = []
    for i in range(1, n):
        if stats[i, cv2.CC_STAT_AREA] >= MIN_PX:
            boxes += _boxes(surface, labels == i)
    return Obstacles(tuple(boxes), _thinned(surface, _standing(scene, foreground)))


def _boxes(surface: Surface, bits: Bits) -> list[Box3d]:
    """One upright box around a body, or one around each of its plates."""
    points_of = surface.points_world_m[bits & surface.valid]
    if len(points_of) < MIN_PX:
        return []
    points: Array = points_of[:: max(1, len(points_of) // _SAMPLES)].astype(np.float64)
    if not plates.are_plates(points):
        return _around(points, surface.support_z_m)
    found = plates.strips(points[:, :2], MAX_PLATES)
    least = MIN_PLATE_SHARE * len(points)
    own = [points[one.which] for one in found if one.which.sum() >= least]
    return [box for plate in own for box in _around(plate, surface.support_z_m)]


def _around(points: Array, support_z_m: float) -> list[Box3d]:
    """The smallest upright box from the support to the top of the points; none when flat."""
    top = float(np.percentile(points[:, 2], 98))
    if top - support_z_m < MIN_HEIGHT_M:
        return []
    (x, y), (a, b), degrees = cv2.minAreaRect(points[:, :2].astype(np.float32))
    return [
        Box3d(
            center_world_m=(float(x), float(y), 0.5 * (support_z_m + top)),
            size_m=(max(float(a), MIN_SIZE_M), max(float(b), MIN_SIZE_M), top - support_z_m),
            yaw_rad=float(np.deg2rad(degrees)),
        )
    ]


def _standing(scene: SceneView, foreground: Foreground) -> Bits:
    surface = scene.surface
    standing = foreground.sure.copy()
    if scene.container is not None:
        standing |= scene.container.mask & (surface.height_m > MIN_SIZE_M)
    for candidate in scene.candidates:
        standing |= candidate.bits & (surface.height_m > MIN_SIZE_M)
    return np.asarray(standing & surface.measured & (surface.depth_m < FAR_M))


def _thinned(surface: Surface, bits: Bits) -> Floats:
    """(n, 3) one point of each cube."""
    points = surface.points_world_m[bits]
    if not len(points):
        return np.zeros((0, 3), dtype=np.float32)
    cells = np.floor((points - points.min(0)) / THIN_TO_M).astype(np.int64)
    span = cells.max(0) + 1
    keys = (cells[:, 0] * span[1] + cells[:, 1]) * span[2] + cells[:, 2]
    _, first = np.unique(keys, return_index=True)
    return np.ascontiguousarray(points[first], dtype=np.float32)
