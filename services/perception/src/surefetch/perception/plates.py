"""Upright plates among points seen from above: straight thin strips. Pure."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array

THICKNESS_M: Final = 0.010
"""What of a plate of 6 mm shows from above, with noise"""
_YAWS: Final = np.deg2rad(np.arange(0.0, 180.0, 3.0))

Which = NDArray[np.bool_]


def strips(xy_m: Array, at_most: int) -> list[Which]:
    """The strips that hold the most of the points (n, 2), one after the other, disjoint."""
    left = np.arange(len(xy_m))
    found = []
    for _ in range(at_most):
        if not len(left):
            break
        inside = _best_strip(xy_m[left])
        which = np.zeros(len(xy_m), dtype=np.bool_)
        which[left[inside]] = True
        found.append(which)
        left = left[~inside]
    return found


def share_in_strips(xy_m: Array, n: int) -> float:
    """Share of the points (n, 2) that lie in the best n strips."""
    return float(np.any(strips(xy_m, n), axis=0).mean())


def _best_strip(xy_m: Array) -> Which:
    """Which points lie in the straight strip that holds the most of them."""
    across = np.outer(np.cos(_YAWS), xy_m[:, 0]) + np.outer(np.sin(_YAWS), xy_m[:, 1])
    order = np.sort(across, axis=1)
    held = np.stack([np.searchsorted(row, row + THICKNESS_M, "right") for row in order])
    held -= np.arange(len(xy_m))
    yaw, first = np.unravel_index(int(np.argmax(held)), held.shape)
    start = order[yaw, first]
    inside: Which = (across[yaw] >= start) & (across[yaw] <= start + THICKNESS_M)
    return inside
