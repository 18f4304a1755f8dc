"""How much a body looks like what is asked, at a glance: what to look at first. Pure."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.perception.answers.color import HUES_DEG
from surefetch.perception.histogram import CHROMATIC_SATURATION, CHROMATIC_VALUE, hsv_of
from surefetch.perception.mask import Bits
from surefetch.perception.surface import Surface

HUE_REACH_DEG: Final = 40.0
DARK_VALUE: Final = 0.30
AS_HIGH_AS_WIDE: Final = frozenset({"cube", "ball"})
TOO_WIDE_M: Final = 0.14
"""No hand of this size holds it"""
_STRIDE_PX: Final = 400


def of_color(rgb: NDArray[np.uint8], color: str | None) -> float:
    """Share of pixels (n, 3) that may have the colour, in [0, 1]; 1 when none is asked."""
    if color is None or len(rgb) == 0:
        return 1.0
    hsv = hsv_of(rgb[:: max(1, len(rgb) // _STRIDE_PX)])
    hue, saturation, value = hsv[:, 0], hsv[:, 1], hsv[:, 2]
    chromatic = (saturation >= CHROMATIC_SATURATION) & (value >= CHROMATIC_VALUE)
    if color == "white":
        return float(np.mean(~chromatic & (value >= DARK_VALUE)))
    if color == "black":
        return float(np.mean(~chromatic & (value < DARK_VALUE)))
    if color not in HUES_DEG:
        return 1.0
    gap = np.abs((hue - HUES_DEG[color] + 180.0) % 360.0 - 180.0)
    return float(np.mean(np.where(chromatic, np.clip(1.0 - gap / HUE_REACH_DEG, 0.0, 1.0), 0.0)))


def of_build(surface: Surface, bits: Bits, shape: str | None) -> float:
    """Whether the visible proportions allow the shape and a hand can hold it, in [0, 1]."""
    points = surface.points_world_m[bits & surface.valid]
    if len(points) < _STRIDE_PX // 10:
        return 0.5
    away = points[:, :2].mean(0) - surface.eye_world_m[:2]
    across = np.array([-away[1], away[0]]) / max(float(np.hypot(*away)), 1e-9)
    low, high = np.percentile(points[:, :2] @ across, (3, 97))
    width = float(high - low)
    if width > TOO_WIDE_M:
        return 0.0
    if shape not in AS_HIGH_AS_WIDE:
        return 1.0
    height = float(np.percentile(points[:, 2], 98)) - surface.support_z_m
    return float(np.clip(2.0 - 3.0 * abs(np.log(max(height, 1e-3) / max(width, 1e-3))), 0.0, 1.0))
