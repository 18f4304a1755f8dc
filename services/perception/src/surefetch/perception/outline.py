"""The outline of a mask: what of it is the body's silhouette, and what something hides. Pure."""

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.mask import Bits, box_of
from surefetch.perception.surface import Floats, Surface

NEARER_M: Final = 0.015
"""What hides a body is nearer than it by this."""
BEHIND_M: Final = 0.006
"""What a body stands in front of is farther than it by this."""
GROUND_M: Final = 0.003
FRAME_PX: Final = 2
_MARGIN: Final = 4
_RING: Final = np.ones((5, 5), np.uint8)
_Window = tuple[slice, slice]
_STEPS: Final = ((0, 1), (0, -1), (1, 0), (-1, 0))


@dataclass(frozen=True, eq=False)
class Outline:
    """Facts about one mask's outline."""

    samples_px: Array
    """(n, 2) points (x, y) on the silhouette, between the last pixel in and the first out"""
    occluded_share: float
    """Share of the ring around the mask that something nearer covers"""
    border_share: float
    """Share of the outline's pixels within 2 px of the image border"""


def outline_of(surface: Surface, base_m: float, bits: Bits) -> Outline:
    """Facts about the mask (h, w) of a body that stands at world height `base_m`."""
    if not bits.any():
        return Outline(np.zeros((0, 2)), 0.0, 0.0)
    x0, y0, x1, y1 = (int(v) for v in box_of(bits))
    h, w = bits.shape
    top, left = max(0, y0 - _MARGIN), max(0, x0 - _MARGIN)
    crop = (slice(top, min(h, y1 + _MARGIN)), slice(left, min(w, x1 + _MARGIN)))
    own, depth = bits[crop], surface.depth_m[crop]
    on_ground = surface.valid[crop] & (surface.points_world_m[crop][..., 2] < base_m + GROUND_M)
    samples = _silhouette(own, depth, on_ground)
    return Outline(
        samples + [left, top],
        _occluded_share(own, depth),
        _border_share(own, top, left, h, w),
    )


def _silhouette(own: Bits, depth: Floats, on_ground: Bits) -> Array:
    """(n, 2) middles between a pixel in and its neighbour out that lies behind or on the ground."""
    found = []
    for dy, dx in _STEPS:
        inside, outside = _shifted(own.shape, dy, dx)
        behind = (depth[outside] == 0) | (depth[outside] > depth[inside] + BEHIND_M)
        crossed = own[inside] & ~own[outside] & (behind | on_ground[outside])
        rows, columns = np.nonzero(crossed)
        rows, columns = rows + max(0, -dy), columns + max(0, -dx)
        found.append(np.column_stack([columns + dx / 2, rows + dy / 2]))
    return np.concatenate(found)


def _shifted(shape: tuple[int, ...], dy: int, dx: int) -> tuple[_Window, _Window]:
    """Windows of pixels and of their neighbours at (dy, dx)."""
    h, w = shape
    here = (slice(max(0, -dy), h - max(0, dy)), slice(max(0, -dx), w - max(0, dx)))
    there = (slice(max(0, dy), h + min(0, dy)), slice(max(0, dx), w + min(0, dx)))
    return here, there


def _occluded_share(own: Bits, depth: Floats) -> float:
    grown = cv2.dilate(own.astype(np.uint8), _RING) > 0
    ring = grown & ~own
    nearest_own = cv2.erode(np.where(own & (depth > 0), depth, np.float32(9)), _RING)
    hidden = ring & (depth > 0) & (depth < nearest_own - NEARER_M)
    n = int(np.count_nonzero(ring))
    return int(np.count_nonzero(hidden)) / n if n else 0.0


def _border_share(own: Bits, top: int, left: int, height: int, width: int) -> float:
    edge = own & ~(cv2.erode(own.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)
    rows, columns = np.nonzero(edge)
    rows, columns = rows + top, columns + left
    at_border = (rows < FRAME_PX) | (rows >= height - FRAME_PX)
    at_border |= (columns < FRAME_PX) | (columns >= width - FRAME_PX)
    return float(np.mean(at_border)) if len(rows) else 0.0
