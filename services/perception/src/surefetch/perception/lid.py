"""Lids: flat level plates that bear a knob, or stick out over walls. Pure."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.messages import Box3d
from surefetch.perception.rectangle import CELL_M, Rectangle
from surefetch.perception.rim import LEVEL_TOLERANCE_M
from surefetch.perception.surface import Floats, Surface

KNOB_M: Final = 0.008
"""Things higher than this on a lid are its knob."""
MIN_OVERHANG_M: Final = 0.0035


@dataclass(frozen=True, eq=False)
class Plate:
    """A flat level rectangle that may be a lid."""

    plate: Rectangle
    top_m: float
    knob: Box3d | None
    overhang_m: float | None
    """Over the walls below; None when too little of them is seen"""

    @property
    def sticks_out(self) -> bool:
        overhang_m = self.overhang_m
        return overhang_m is not None and overhang_m > MIN_OVERHANG_M and self.plate.coverage > 0.85


def measured(
    surface: Surface, points: Floats, heights: Floats, plate: Rectangle, level: float
) -> Plate:
    plate, top = _plate_edges(points, heights, plate, level)
    overhang = _overhang(points, heights, plate, top)
    return Plate(plate, top, _knob(surface, plate, top), overhang)


def _plate_edges(
    points: Floats, heights: Floats, plate: Rectangle, level: float
) -> tuple[Rectangle, float]:
    near = (np.abs(heights - level) < LEVEL_TOLERANCE_M) & (plate.inset(points[:, :2]) > -0.008)
    top = float(np.median(heights[near])) if near.sum() > 50 else level
    c, s = np.cos(plate.yaw_rad), np.sin(plate.yaw_rad)
    x, y = points[near, 0].astype(np.float64), points[near, 1].astype(np.float64)
    u, v = x * c + y * s, y * c - x * s
    return replace(plate, u_m=_ends(u, v, plate.u_m), v_m=_ends(v, u, plate.v_m)), top


def _ends(
    across: NDArray[np.float64], along: NDArray[np.float64], guess: tuple[float, float]
) -> tuple[float, float]:
    """Where most rows of a plate begin and end; what touches it in a few does not count."""
    rows = np.floor((along - along.min()) / CELL_M).astype(int) if len(along) else along.astype(int)
    counts = np.bincount(rows)
    full = counts >= max(5, 0.3 * float(np.median(counts[counts > 0]))) if len(counts) else counts
    if np.count_nonzero(full) < 5:
        return guess
    first, last = np.full(len(counts), np.inf), np.full(len(counts), -np.inf)
    np.minimum.at(first, rows, across)
    np.maximum.at(last, rows, across)
    return float(np.median(first[full])), float(np.median(last[full]))


def _overhang(points: Floats, heights: Floats, plate: Rectangle, top: float) -> float | None:
    """How far the plate sticks out over the walls, from the walls seen below it."""
    below = (heights < top - 0.012) & (heights > 0.01)
    inset = plate.inset(points[:, :2])
    wall = inset[below & (inset > -0.01) & (inset < 0.03)]
    return float(np.median(wall)) if len(wall) > 100 else None


def _knob(surface: Surface, plate: Rectangle, top: float) -> Box3d | None:
    on_top = surface.valid & (surface.height_m > top + KNOB_M)
    on_top &= surface.height_m < top + 0.08
    on_top &= plate.inset(surface.points_world_m[..., :2]) > 0.01
    if on_top.sum() < 20:
        return None
    points = surface.points_world_m[on_top]
    own = plate.own(points[:, :2])
    low, high = np.percentile(own, 2, axis=0), np.percentile(own, 98, axis=0)
    middle, size = 0.5 * (low + high), high - low
    c, s = np.cos(plate.yaw_rad), np.sin(plate.yaw_rad)
    x = plate.center_m[0] + middle[0] * c - middle[1] * s
    y = plate.center_m[1] + middle[0] * s + middle[1] * c
    z_low, z_high = surface.support_z_m + top, float(np.percentile(points[:, 2], 97))
    return Box3d(
        center_world_m=(float(x), float(y), 0.5 * (z_low + z_high)),
        size_m=(float(size[0]), float(size[1]), z_high - z_low),
        yaw_rad=plate.yaw_rad,
    )
