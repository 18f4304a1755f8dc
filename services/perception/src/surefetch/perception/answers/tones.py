"""Which pixels of a body have another colour than most of it. Pure.

Lights change brightness but hardly hue, so a coloured body is told from its marking by hue and
saturation. Bodies without hue (white, black) are told by brightness: a shadow darkens by less than
the step from white to black.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.perception.answers.faces import Bools
from surefetch.perception.histogram import hsv_of

MIN_CHROMA: Final = 0.075
MIN_SATURATION: Final = 0.22
COLORED_SHARE: Final = 0.1
"""Markings are dark or light: this much of a hue is the body's, however large the marking."""
HUE_STEP_DEG: Final = 25.0
PALER: Final = 0.5
"""A pixel of less than this part of the body's saturation is no longer its colour."""
GREY_VALUE: Final = 0.28
"""Between the brightest parts of black and white in shadow."""
BETWEEN_BLACK_AND_WHITE: Final = (0.18, 0.42)
CUT_WIDTH: Final = 0.12
"""In logarithms: pixels so near to a cut speak against it."""


@dataclass(frozen=True, eq=False)
class Tones:
    """Pixels (n,) of a body in two tones at most."""

    hsv: NDArray[np.float32]
    """(n, 3)"""
    clipped: Bools
    """(n,) too bright for the camera: the hue is not to be trusted"""
    colored: bool
    """The body has a hue"""
    other: Bools
    """(n,) not the body's tone; for a body without hue, the smaller part"""
    hue_share: float
    """Share of the pixels that have a hue"""


def tones_of(rgb: NDArray[np.uint8]) -> Tones:
    """Split pixels (n, 3) into the body's tone and another."""
    hsv = hsv_of(rgb)
    chroma = hsv[:, 1] * hsv[:, 2]
    chromatic: Bools = (chroma > MIN_CHROMA) & (hsv[:, 1] > MIN_SATURATION)
    clipped: Bools = np.asarray((rgb >= 254).any(1))
    hue_share = float(chromatic.mean())
    if hue_share >= COLORED_SHARE:
        return Tones(hsv, clipped, True, _off_hue(hsv, chromatic), hue_share)
    dark = _dark(hsv[:, 2].astype(np.float64))
    other = dark if dark.mean() <= 0.5 else ~dark
    return Tones(hsv, clipped, False, other, hue_share)


def _off_hue(hsv: NDArray[np.float32], chromatic: Bools) -> Bools:
    hue = main_hue(hsv[chromatic, 0], hsv[chromatic, 1] * hsv[chromatic, 2])
    own = chromatic & (np.abs(hue_difference(hsv[:, 0], hue)) < HUE_STEP_DEG)
    if not own.any():
        return ~chromatic
    saturation = float(np.median(hsv[own, 1]))
    other: Bools = ~own | (hsv[:, 1] < PALER * saturation)
    return other


def main_hue(hue_deg: NDArray[np.float32], weight: NDArray[np.float32]) -> float:
    """The fullest 12 degrees of a circular histogram, refined by the median around it."""
    counts = np.bincount((hue_deg / 4.0).astype(int) % 90, weights=weight, minlength=90)
    smooth = counts + np.roll(counts, 1) + np.roll(counts, -1)
    peak = (float(smooth.argmax()) + 0.5) * 4.0
    off = hue_difference(hue_deg, peak)
    near = np.abs(off) < HUE_STEP_DEG
    return float((peak + np.median(off[near])) % 360.0) if near.any() else peak


def hue_difference(hue_deg: NDArray[np.float32], of_deg: float) -> NDArray[np.float32]:
    """Signed degrees (n,) in [-180, 180)."""
    out: NDArray[np.float32] = (hue_deg - np.float32(of_deg) + 180.0) % 360.0 - 180.0
    return out


def hue_gap(a_deg: float, b_deg: float) -> float:
    """Degrees between two hues, in [0, 180]."""
    return abs((a_deg - b_deg + 180.0) % 360.0 - 180.0)


def _dark(value: Array) -> Bools:
    """(n,) pixels darker than the emptiest brightness between black and white.

    Lit black stays below it, white in shadow above, and a body with both has few pixels between.
    """
    level = np.log(np.maximum(value, 0.01))
    cuts = np.log(np.linspace(*BETWEEN_BLACK_AND_WHITE, 17))
    crossing = (np.abs(level[:, None] - cuts) < CUT_WIDTH).sum(0)
    emptiest = np.flatnonzero(crossing == crossing.min())
    usual = np.abs(cuts[emptiest] - np.log(GREY_VALUE)).argmin()
    dark: Bools = level < cuts[emptiest[usual]]
    return dark
