"""Silhouettes of upright bodies are convex, except where something nearer hides them. Pure.

So a silhouette with a notch is of two bodies that touch, and is cut there; and two pieces whose
common hull is filled by what is nearer than they are may be one body that something crosses.
"""

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.mask import Bits, window
from surefetch.perception.surface import Floats

BEHIND_M: Final = 0.008
MAX_NOTCH_SHARE: Final = 0.04
"""Of the hull's area; more is no single body."""
MIN_DEFECT_PX: Final = 3.0
MIN_DEFECT_SHARE: Final = 0.05
"""Depth of a notch over the square root of the area"""
MIN_PART_SHARE: Final = 0.2
MIN_PART_PX: Final = 100
_MARGIN: Final = 3

Point = NDArray[np.int32]


@dataclass(frozen=True)
class Notch:
    """A place where the silhouette turns inwards and what lies behind shows."""

    point: tuple[int, int]
    """Deepest pixel (x, y)"""
    depth_px: float


def notched_share(bits: Bits, depth_m: Floats) -> float:
    """Share of the convex hull through which one sees what lies behind the body."""
    hull = hull_of(_contour(bits), bits.shape)
    behind = hull & ~bits & seen_through(bits, depth_m)
    return int(np.count_nonzero(behind)) / max(1, int(np.count_nonzero(hull)))


def hull_of(points_px: Point, shape: tuple[int, ...]) -> Bits:
    """The pixels (h, w) of the convex hull of points (n, 1, 2)."""
    hull = np.zeros(shape, dtype=np.uint8)
    cv2.fillConvexPoly(hull, cv2.convexHull(points_px), 1)
    return hull > 0


def seen_through(bits: Bits, depth_m: Floats) -> Bits:
    """Pixels (h, w) beside a body that show what lies behind it."""
    return np.asarray((depth_m == 0) | (depth_m > _depth_around(bits, depth_m) + BEHIND_M))


def split(bits: Bits, depth_m: Floats) -> list[Bits]:
    """The single bodies in a mask (h, w): cut at notches as long as that helps."""
    at = window([bits], _MARGIN)
    parts = _split(bits[at], depth_m[at])
    if len(parts) == 1:
        return [bits]
    out = []
    for part in parts:
        whole = np.zeros_like(bits)
        whole[at] = part
        out.append(whole)
    return out


def _split(bits: Bits, depth_m: Floats) -> list[Bits]:
    before = notched_share(bits, depth_m)
    if before < MAX_NOTCH_SHARE:
        return [bits]
    best: tuple[float, tuple[Bits, Bits]] | None = None
    for start, end in _cuts(bits, depth_m):
        parts = _cut(bits, start, end)
        if parts is None:
            continue
        after = sum(notched_share(part, depth_m) * part.sum() for part in parts) / bits.sum()
        if best is None or after < best[0]:
            best = (after, parts)
    if best is None or best[0] > 0.5 * before:
        return [bits]
    return [*_split(best[1][0], depth_m), *_split(best[1][1], depth_m)]


def _cuts(bits: Bits, depth_m: Floats) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Lines from notch to notch, and from a notch straight across."""
    notches = _notches(bits, depth_m)
    lines = [(a.point, b.point) for i, a in enumerate(notches) for b in notches[i + 1 :]]
    contour = _contour(bits)[:, 0, :]
    for notch in notches:
        apart = np.linalg.norm(contour - np.array(notch.point), axis=1)
        here = int(np.argmin(apart))
        steps = np.abs(np.arange(len(contour)) - here)
        steps = np.minimum(steps, len(contour) - steps)
        far = steps > 0.2 * len(contour)
        if far.any():
            x, y = contour[far][int(np.argmin(apart[far]))]
            lines.append((notch.point, (int(x), int(y))))
    return lines


def _notches(bits: Bits, depth_m: Floats) -> list[Notch]:
    contour = _contour(bits)
    hull = cv2.convexHull(contour, returnPoints=False)
    if hull is None or len(hull) < 4 or len(contour) < 8:
        return []
    hull[::-1].sort(axis=0)
    defects = cv2.convexityDefects(contour, hull)
    if defects is None:
        return []
    least = max(MIN_DEFECT_PX, MIN_DEFECT_SHARE * float(np.sqrt(bits.sum())))
    found = []
    for _, _, at, depth in defects[:, 0, :]:
        if depth / 256.0 >= least:
            x, y = contour[at, 0]
            if _sees_behind(bits, depth_m, int(x), int(y)):
                found.append(Notch((int(x), int(y)), depth / 256.0))
    found.sort(key=lambda notch: -notch.depth_px)
    return found[:3]


def _sees_behind(bits: Bits, depth_m: Floats, x: int, y: int) -> bool:
    """Beside the pixel, most of what is not the body lies behind it."""
    rows, columns = slice(max(0, y - 3), y + 4), slice(max(0, x - 3), x + 4)
    beside = ~bits[rows, columns]
    depth = depth_m[rows, columns][beside]
    behind = (depth == 0) | (depth > depth_m[y, x] + BEHIND_M)
    return bool(beside.any()) and float(behind.mean()) > 0.5


def _cut(bits: Bits, start: tuple[int, int], end: tuple[int, int]) -> tuple[Bits, Bits] | None:
    """The two sides of a line through the mask; None when one of them is too small."""
    line = np.zeros(bits.shape, dtype=np.uint8)
    cv2.line(line, start, end, 1, 1)
    left = (bits & (cv2.dilate(line, np.ones((2, 2), np.uint8)) == 0)).astype(np.uint8)
    n, labels, stats, _ = cv2.connectedComponentsWithStats(left, connectivity=4)
    if n < 3:
        return None
    order = np.argsort(-stats[1:, cv2.CC_STAT_AREA])[:2] + 1
    least = max(MIN_PART_PX, MIN_PART_SHARE * float(bits.sum()))
    if stats[order[1], cv2.CC_STAT_AREA] < least:
        return None
    to_first = cv2.distanceTransform((labels != order[0]).astype(np.uint8), cv2.DIST_L2, 3)
    to_second = cv2.distanceTransform((labels != order[1]).astype(np.uint8), cv2.DIST_L2, 3)
    first = bits & (to_first <= to_second)
    return np.asarray(first), np.asarray(bits & ~first)


def _contour(bits: Bits) -> Point:
    """The outer outline (n, 1, 2) of the largest piece."""
    contours, _ = cv2.findContours(bits.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return np.asarray(max(contours, key=len), dtype=np.int32)


def _depth_around(bits: Bits, depth_m: Floats) -> Floats:
    """(h, w) depth of the body's pixels, spread over the pixels beside it."""
    own = bits & (depth_m > 0)
    mean = np.float32(depth_m[own].mean()) if own.any() else np.float32(0)
    size = (15, 15)
    weight = cv2.blur(own.astype(np.float32), size)
    total = cv2.blur(np.where(own, depth_m, np.float32(0)), size)
    near = np.where(weight > 0.02, total / np.maximum(weight, np.float32(1e-6)), mean)
    return np.asarray(near, dtype=np.float32)
