"""From foreground to single bodies: cut at jumps in depth and at notches, pieces merged. Pure."""

from typing import Final

import cv2
import numpy as np

from surefetch.common.mask import Bits
from surefetch.perception.foreground import Foreground, Labels, sharpened
from surefetch.perception.fragments import merged
from surefetch.perception.silhouette import split
from surefetch.perception.surface import Floats, Surface

MIN_PX: Final = 40
"""Smaller parts belong to something else, or to nothing."""
STEP_M: Final = 0.005


def find(surface: Surface, foreground: Foreground) -> list[Bits]:
    """The visible pixels of each body, the largest first."""
    depth: Floats = cv2.medianBlur(surface.depth_m, 5).astype(np.float32, copy=False)
    labels = components(foreground.sure, _smooth(depth, 1), _smooth(depth, 0))
    sizes = np.bincount(labels.ravel())
    kept = sizes >= MIN_PX
    kept[0] = False
    labels = np.where(kept[labels], labels, 0)
    doubtful = foreground.doubtful | (foreground.sure & (labels == 0))
    labels = sharpened(surface.frame.rgb, labels, doubtful)
    found = merged(surface, [labels == i for i in np.flatnonzero(kept)])
    return [part for bits in found for part in split(bits, surface.depth_m)]


def _smooth(depth: Floats, axis: int) -> Bits:
    """Between a pixel and the next on an axis: no jump beyond what the slopes beside explain.

    (h, w - 1) for axis 1, (h - 1, w) for axis 0.
    """
    step = np.diff(depth, axis=axis)
    size = np.abs(step)
    pad = [(0, 0), (0, 0)]
    pad[axis] = (1, 1)
    wide = np.pad(size, pad, mode="edge")
    before = wide[:, :-2] if axis == 1 else wide[:-2]
    after = wide[:, 2:] if axis == 1 else wide[2:]
    return np.asarray(size - np.minimum(before, after) < STEP_M)


def components(mask: Bits, right: Bits, down: Bits) -> Labels:
    """Connected parts of a mask; neighbours are connected where `right` and `down` say so."""
    h, w = mask.shape
    grid = np.zeros((2 * h - 1, 2 * w - 1), dtype=np.uint8)
    grid[::2, ::2] = mask
    grid[::2, 1::2] = mask[:, 1:] & mask[:, :-1] & right
    grid[1::2, ::2] = mask[1:] & mask[:-1] & down
    _, labels = cv2.connectedComponents(grid, connectivity=4, ltype=cv2.CV_32S)
    return np.ascontiguousarray(labels[::2, ::2])
