"""Whether a solid could stand where a body is seen, by what is seen beside and behind it. Pure.

A solid is contradicted by background seen through it, and by pixels of the body beside it. What an
occluder covers speaks neither for nor against.
"""

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.common.mask import Bits, box_of
from surefetch.perception.answers import faces
from surefetch.perception.solids import Solid
from surefetch.perception.surface import Surface

BEHIND_M: Final = 0.006
"""Nearer to the solid's surface than this is not seen through it."""
MARGIN_PX: Final = 24
MAX_GRID: Final = 4000


class Window:
    """The image around a body, thinned where it is large."""

    def __init__(self, surface: Surface, bits: Bits) -> None:
        x0, y0, x1, y1 = (int(v) for v in box_of(bits))
        height, width = bits.shape
        rows = np.arange(max(0, y0 - MARGIN_PX), min(height, y1 + MARGIN_PX))
        columns = np.arange(max(0, x0 - MARGIN_PX), min(width, x1 + MARGIN_PX))
        step = max(1, int(np.ceil(np.sqrt(len(rows) * len(columns) / MAX_GRID))))
        grid = np.meshgrid(rows[::step], columns[::step], indexing="ij")
        self._surface = surface
        self._rows, self._columns = (part.ravel() for part in grid)
        self._share = float(step * step)
        self._own = bits[self._rows, self._columns]
        sure = cv2.erode(bits.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
        near = cv2.dilate(bits.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        self._inner = sure[self._rows, self._columns]
        self._outer = ~near[self._rows, self._columns]
        points = surface.points_world_m[self._rows, self._columns].astype(np.float64)
        self._seen_m = np.linalg.norm(points - surface.eye_world_m, axis=1)
        self._valid = surface.valid[self._rows, self._columns]
        self._rays = rays_of(surface, self._rows, self._columns)

    def against_px(self, solid: Solid) -> float:
        """Pixels that speak against the solid."""
        laid = faces.lay(solid, self._rays, self._surface.eye_world_m)
        through = laid.met & self._outer & self._valid
        through &= self._seen_m > laid.distance_m + BEHIND_M
        beside = self._inner & ~laid.hit
        return self._share * float(np.count_nonzero(through) + np.count_nonzero(beside))


def rays_of(surface: Surface, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
    """(n, 3) directions of pixels in the world, of any length."""
    K = surface.frame.K
    camera = np.column_stack(
        [(columns - K[0, 2]) / K[0, 0], (rows - K[1, 2]) / K[1, 1], np.ones(len(rows))]
    )
    rays: Array = camera @ surface.T_world_camera[:3, :3].T
    return rays
