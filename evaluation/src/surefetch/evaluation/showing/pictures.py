"""Masks and tracks on images: what the figures and the Rerun view share. Pure."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.mask import Bits
from surefetch.common.messages import Detection, TrackSummary

Rgb8 = tuple[int, int, int]

PALETTE: Final[tuple[Rgb8, ...]] = (
    (0, 114, 178),
    (230, 159, 0),
    (0, 158, 115),
    (204, 121, 167),
    (86, 180, 233),
    (213, 94, 0),
    (240, 228, 66),
    (148, 103, 189),
)
"""Told apart by colour-blind readers too.

Source: Okabe and Ito, Color universal design (2008).
"""
SAME_CENTER_M: Final = 1e-6
"""A track takes over the centre of its newest detection."""


def track_color(track: int) -> Rgb8:
    """The colour of a track in every picture."""
    return PALETTE[(track - 1) % len(PALETTE)]


def track_of(detection: Detection, tracks: Sequence[TrackSummary]) -> TrackSummary | None:
    """The track that took this detection in this step, if one did."""
    if detection.center_world_m is None:
        return None
    center = np.asarray(detection.center_world_m)
    for track in tracks:
        if np.abs(center - np.asarray(track.center_world_m)).max() < SAME_CENTER_M:
            return track
    return None


def outline(mask: Bits, width_px: int = 2) -> Bits:
    """The inner border of a mask."""
    inner = mask.copy()
    for _ in range(width_px):
        shrunk = inner.copy()
        shrunk[1:] &= inner[:-1]
        shrunk[:-1] &= inner[1:]
        shrunk[:, 1:] &= inner[:, :-1]
        shrunk[:, :-1] &= inner[:, 1:]
        inner = shrunk
    return mask & ~inner


def paint(rgb: NDArray[np.uint8], mask: Bits, color: Rgb8, opacity: float) -> NDArray[np.uint8]:
    """The image with the mask tinted and its border drawn."""
    painted = rgb.astype(np.float64)
    painted[mask] = (1 - opacity) * painted[mask] + opacity * np.asarray(color)
    painted[outline(mask)] = color
    return painted.astype(np.uint8)
