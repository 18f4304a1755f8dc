"""Upright plates among points seen from above: straight thin strips. Pure."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array

THICKNESS_M: Final = 0.014
"""What of a plate of 8 mm shows from above, with noise"""
SLENDER: Final = 0.22
MIN_THICKNESS_M: Final = 0.009
"""A plate is that slender; what looks short may not look thick"""
EDGE_M: Final = 0.007
MIN_EDGE_POINTS: Final = 20
MIN_EDGE_SHARE: Final = 0.92
MIN_SHARE: Final = 0.8
MIN_CORNER_RAD: Final = float(np.deg2rad(18.0))
"""Strips that are more parallel than this are no two plates but one broad body"""
_YAWS: Final = np.deg2rad(np.arange(0.0, 180.0, 3.0))

Which = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Strip:
    """Points in a straight strip."""

    which: Which
    """(n,)"""
    normal_rad: float
    """Direction across it, in [0, pi)"""


def strips(xy_m: Array, at_most: int, thickness_m: float = THICKNESS_M) -> list[Strip]:
    """The strips that hold the most of the points (n, 2), one after the other, disjoint."""
    left = np.arange(len(xy_m))
    found = []
    for _ in range(at_most):
        if not len(left):
            break
        inside, normal = _best_strip(xy_m[left], thickness_m)
        which = np.zeros(len(xy_m), dtype=np.bool_)
        which[left[inside]] = True
        found.append(Strip(which, normal))
        left = left[~inside]
    return found


def are_plates(points_m: Array) -> bool:
    """Points (n, 3) of one upright plate, or of two that meet at an angle.

    The upper edge tells: seen from above, a plate's is a line and a body's top is not.
    """
    edge = points_m[points_m[:, 2] > np.percentile(points_m[:, 2], 98) - EDGE_M]
    upper = edge if len(edge) >= MIN_EDGE_POINTS else points_m
    return _share(upper[:, :2]) > MIN_EDGE_SHARE and _share(points_m[:, :2]) > MIN_SHARE


def _share(xy_m: Array) -> float:
    """Share of the points (n, 2) in the best strip and in one that meets it at an angle."""
    low, high = np.percentile(xy_m, (2, 98), axis=0)
    extent = float(np.hypot(*(high - low)))
    thickness = float(np.clip(SLENDER * extent, MIN_THICKNESS_M, THICKNESS_M))
    first, *more = strips(xy_m, 2, thickness)
    share = float(first.which.mean())
    for second in more:
        turn = abs(second.normal_rad - first.normal_rad)
        if min(turn, np.pi - turn) > MIN_CORNER_RAD:
            share += float(second.which.mean())
    return share


def _best_strip(xy_m: Array, thickness_m: float) -> tuple[Which, float]:
    """Which points lie in the straight strip that holds the most of them, and its normal."""
    across = np.outer(np.cos(_YAWS), xy_m[:, 0]) + np.outer(np.sin(_YAWS), xy_m[:, 1])
    order = np.sort(across, axis=1)
    held = np.stack([np.searchsorted(row, row + thickness_m, "right") for row in order])
    held -= np.arange(len(xy_m))
    yaw, first = np.unravel_index(int(np.argmax(held)), held.shape)
    start = order[yaw, first]
    inside: Which = (across[yaw] >= start) & (across[yaw] <= start + thickness_m)
    return inside, float(_YAWS[yaw])
