"""Screens: matt grey upright plates that hide things. Obstacles, never objects. Pure."""

from typing import Final

import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.mask import Bits
from surefetch.perception import plates
from surefetch.perception.container import Container
from surefetch.perception.histogram import hsv_of
from surefetch.perception.surface import Surface

MAX_SATURATION: Final = 0.16
MIN_VALUE: Final = 0.13
MAX_VALUE: Final = 0.62
HIGH_M: Final = 0.070
LOW_M: Final = 0.045
BROAD_M: Final = 0.072
"""Screens are high, or broad and not low"""
MAX_OBJECT_HEIGHT_M: Final = 0.125
MAX_OBJECT_WIDTH_M: Final = 0.30
_SAMPLES: Final = 800


def is_screen(surface: Surface, container: Container | None, bits: Bits) -> bool:
    """Grey and all of it in one or two large upright plates, or of a size that no object has.

    In the container there are none.
    """
    seen = surface.points_world_m[bits & surface.valid]
    if len(seen) < 20:
        return False
    points: Array = seen[:: max(1, len(seen) // _SAMPLES)].astype(np.float64)
    height = float(np.percentile(points[:, 2], 98)) - surface.support_z_m
    low, high = np.percentile(points[:, :2], (2, 98), axis=0)
    width = float((high - low).max())
    if width > MAX_OBJECT_WIDTH_M:
        return True
    large = height > HIGH_M or (height > LOW_M and width > BROAD_M)
    if not large or not _is_grey(surface, bits):
        return False
    if container is not None and float(container.holds(points[:, :2]).mean()) > 0.5:
        return False
    return height > MAX_OBJECT_HEIGHT_M or plates.are_plates(points)


def _is_grey(surface: Surface, bits: Bits) -> bool:
    hsv = hsv_of(surface.frame.rgb[bits])
    saturation, value = np.median(hsv[:, 1]), np.median(hsv[:, 2])
    return bool(saturation < MAX_SATURATION and MIN_VALUE < value < MAX_VALUE)
