"""Fourteen colour bins that partition the pixels: ten hues and four greys. Pure.

A pixel counts once. Neighbouring bins share it linearly, so that a small change of light moves
little mass.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

N_HUES: Final = 10
N_VALUES: Final = 4
N_BINS: Final = N_HUES + N_VALUES
CHROMATIC_SATURATION: Final = 0.22
CHROMATIC_VALUE: Final = 0.16


def hsv_of(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Hue in degrees [0, 360), saturation and value in [0, 1]; (..., 3) to (..., 3)."""
    colors = rgb.astype(np.float32) / 255.0
    value = colors.max(-1)
    chroma = value - colors.min(-1)
    safe = np.where(chroma > 0, chroma, 1)
    r, g, b = colors[..., 0], colors[..., 1], colors[..., 2]
    hue = np.where(
        value == r,
        (g - b) / safe % 6,
        np.where(value == g, (b - r) / safe + 2, (r - g) / safe + 4),
    )
    hue = np.where(chroma > 0, hue * 60, 0) % 360
    saturation = chroma / np.where(value > 0, value, 1)
    return np.stack([hue, saturation, value], axis=-1).astype(np.float32)


def histogram(rgb: NDArray[np.uint8]) -> tuple[float, ...] | None:
    """14 bins of pixels (n, 3), summing to 1; None without pixels."""
    if len(rgb) == 0:
        return None
    hsv = hsv_of(rgb)
    hue, saturation, value = hsv[:, 0], hsv[:, 1], hsv[:, 2]
    chromatic = (saturation >= CHROMATIC_SATURATION) & (value >= CHROMATIC_VALUE)
    bins = np.zeros(N_BINS)
    at = hue[chromatic] / (360.0 / N_HUES) - 0.5
    low = np.floor(at).astype(int)
    np.add.at(bins, low % N_HUES, 1.0 - (at - low))
    np.add.at(bins, (low + 1) % N_HUES, at - low)
    at = np.clip(value[~chromatic] * N_VALUES - 0.5, 0.0, N_VALUES - 1.0)
    low = np.minimum(np.floor(at).astype(int), N_VALUES - 2)
    np.add.at(bins, N_HUES + low, 1.0 - (at - low))
    np.add.at(bins, N_HUES + low + 1, at - low)
    return tuple((bins / bins.sum()).tolist())
