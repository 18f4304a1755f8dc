"""Pieces of one body put together again. Pure.

A face seen at a grazing angle comes off its body, and a post in front of a body cuts it in two.
"""

from collections.abc import Sequence
from typing import Final

import cv2
import numpy as np

from surefetch.common.likeness import hellinger
from surefetch.common.mask import Bits, window
from surefetch.perception.histogram import histogram
from surefetch.perception.silhouette import hull_of, seen_through
from surefetch.perception.surface import Surface

SLIVER_PX: Final = 400
SLIVER_SHARE: Final = 0.2
"""A sliver has at most this share of its body's pixels"""
GRAZING_STEP_M: Final = 0.012
MIN_BORDER_SHARE: Final = 0.3
"""Of a sliver's pixels' square root: so much of its outline is shared with its body"""
SAME_COLOR: Final = 0.35
"""Hellinger distance of histograms"""
MAX_WIDTH_M: Final = 0.09
"""Farther apart, pieces of one colour are two bodies for all one can tell"""
MAX_GROWTH: Final = 1.35
"""A wide body may grow by this"""
MAX_OPEN_SHARE: Final = 0.03
"""Of the common hull, where what lies behind shows between the pieces"""
MIN_GAP_SHARE: Final = 0.02
_MARGIN: Final = 2


def merged(surface: Surface, bodies: Sequence[Bits]) -> list[Bits]:
    """The bodies, with slivers and pieces given back to what they are part of."""
    out = sorted(bodies, key=np.count_nonzero, reverse=True)
    for same in (_is_sliver_of, _is_cut_by_something):
        i = 0
        while i < len(out):
            j = next((j for j in range(i + 1, len(out)) if same(surface, out[i], out[j])), None)
            if j is None:
                i += 1
            else:
                out[i] = out[i] | out.pop(j)
    return out


def _is_sliver_of(surface: Surface, body: Bits, sliver: Bits) -> bool:
    n = int(np.count_nonzero(sliver))
    if n > SLIVER_PX or n > SLIVER_SHARE * np.count_nonzero(body):
        return False
    at = window([sliver], _MARGIN)
    own, other, depth = sliver[at], body[at], surface.depth_m[at]
    beside = (cv2.dilate(own.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0) & other
    if not beside.any():
        return False
    nearest = cv2.erode(np.where(own, depth, np.float32(9)), np.ones((3, 3), np.uint8))
    steps = np.abs(nearest[beside] - depth[beside])
    n_close = int(np.count_nonzero(steps < GRAZING_STEP_M))
    return n_close > MIN_BORDER_SHARE * 4 * np.sqrt(n) and _same_color(surface, body, sliver)


def _is_cut_by_something(surface: Surface, a: Bits, b: Bits) -> bool:
    """One colour, near each other, and all between them hidden by what is nearer."""
    both = a | b
    at = window([both], _MARGIN)
    own, depth = both[at], surface.depth_m[at]
    if _width_m(surface, both) > max(MAX_WIDTH_M, MAX_GROWTH * _width_m(surface, a)):
        return False
    hull = hull_of(np.argwhere(own)[:, None, ::-1].astype(np.int32), own.shape)
    gap = hull & ~own
    open_to_behind = gap & seen_through(own, depth)
    n = int(np.count_nonzero(hull))
    if np.count_nonzero(gap) < MIN_GAP_SHARE * n:
        return False
    return int(np.count_nonzero(open_to_behind)) < MAX_OPEN_SHARE * n and _same_color(surface, a, b)


def _width_m(surface: Surface, bits: Bits) -> float:
    """Diagonal of what is seen from above."""
    points = surface.points_world_m[bits & surface.valid][:, :2]
    if not len(points):
        return 0.0
    low, high = np.percentile(points, (2, 98), axis=0)
    return float(np.hypot(*(high - low)))


def _same_color(surface: Surface, a: Bits, b: Bits) -> bool:
    rgb = surface.frame.rgb
    return hellinger(histogram(rgb[a]), histogram(rgb[b])) < SAME_COLOR
