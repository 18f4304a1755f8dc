"""How much a body looks like what is asked, at a glance: what to look at first. Pure."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.perception.answers.color import HUES_DEG
from surefetch.perception.answers.shape import SOLIDS
from surefetch.perception.histogram import CHROMATIC_SATURATION, CHROMATIC_VALUE, hsv_of
from surefetch.perception.lifting import Lifted
from surefetch.perception.solids import Solid

HUE_REACH_DEG: Final = 40.0
DARK_VALUE: Final = 0.30
RMS_REACH: Final = 0.6
LOG_CUBE: Final = float(np.log(1.15))
LOG_REACH: Final = float(np.log(1.35))
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


def of_build(body: Lifted, shape: str | None) -> float:
    """Whether size and fitted solids allow the shape, in [0, 1]; a hand must be able to hold it."""
    solid = body.solid
    if solid is None:
        return 0.5
    if min(solid.size_m[:2]) > TOO_WIDE_M:
        return 0.0
    kind = None if shape is None else SOLIDS.get(shape)
    if kind is None or kind not in body.fits:
        return 1.0
    worse = body.fits[kind].rms - min(fit.rms for fit in body.fits.values())
    return float(np.clip(1.0 - worse / RMS_REACH, 0.0, 1.0)) * _proportions(body.fits[kind], shape)


def _proportions(solid: Solid, shape: str | None) -> float:
    """Whether a box is as long as wide as high, in [0, 1]; 1 for what is no box."""
    if shape not in ("cube", "block"):
        return 1.0
    sides = (*solid.size_m, solid.top_m - solid.base_m)
    longer = float(np.log(max(sides) / max(min(sides), 1e-3)))
    cube = float(np.clip(1.0 - (longer - LOG_CUBE) / LOG_REACH, 0.0, 1.0))
    return cube if shape == "cube" else 1.0 - cube
