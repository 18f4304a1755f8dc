"""How much pixels look like a named colour, for ranking what to look at first. Pure."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.perception.answers.color import HUES_DEG
from surefetch.perception.histogram import CHROMATIC_SATURATION, CHROMATIC_VALUE, hsv_of

HUE_REACH_DEG: Final = 40.0
DARK_VALUE: Final = 0.30
_STRIDE_PX: Final = 400


def likeness(rgb: NDArray[np.uint8], color: str | None) -> float:
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
