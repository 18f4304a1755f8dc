"""Which pixels show something that stands on the support or in the container. Pure.

Depth decides where it can. Near the ground and near the container's walls it cannot tell a body
from what it touches; there, colour decides between the nearest sure body and the nearest sure
background.
"""

from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.mask import Bits
from surefetch.perception.container import Container
from surefetch.perception.surface import Surface

Labels = NDArray[np.int32]
"""(h, w): 0 nothing, from 1 the bodies"""

SURE_M: Final = 0.006
"""Higher above the ground than noise can be, up to `NEAR_M`; from there it grows as noise does."""
NEAR_M: Final = 0.8
FLAT_M: Final = 0.0010
"""Lower than this is the ground."""
WALL_SURE_M: Final = 0.0045
WALL_FLAT_M: Final = 0.0010
REACH_PX: Final = 8
"""How far doubtful pixels may lie from a sure body."""
FAR_M: Final = 1.8
"""Candidates are within an arm's reach of the camera."""


@dataclass(frozen=True, eq=False)
class Foreground:
    """(h, w) each."""

    sure: Bits
    """Shows a body, by depth alone"""
    doubtful: Bits
    """Depth cannot tell it from the ground or from a wall of the container"""
    inside: Bits
    """Over the container's interior"""


def find(surface: Surface, container: Container | None) -> Foreground:
    """Everything above the ground that is not the container."""
    valid = surface.valid & (surface.depth_m < FAR_M)
    sure_m = SURE_M * np.maximum(np.float32(1), surface.depth_m / np.float32(NEAR_M)) ** 2
    if container is None:
        over = np.where(valid, surface.height_m, np.float32(-1))
        nothing = np.zeros_like(valid)
        sure = over > sure_m
        return Foreground(sure, ~sure & ((over > FLAT_M) | ~surface.valid), nothing)
    xy = surface.points_world_m[..., :2]
    inner = container.inner.inset(xy)
    inside = valid & (inner > 0)
    ground = np.where(inside, np.float32(container.floor_m), np.float32(0))
    over = np.where(valid, surface.height_m - ground, np.float32(-1)).astype(np.float32)
    if container.lid is not None:
        sure = (over > sure_m) & ~container.mask
        doubtful = ~sure & ~container.mask & ((over > FLAT_M) | ~surface.valid)
        return Foreground(sure, doubtful, np.zeros_like(valid))
    from_wall = np.maximum(inner, -container.outer.inset(xy))
    above = surface.height_m - container.rim_m
    clear = np.maximum(from_wall, above)
    sure = (over > sure_m) & (clear > WALL_SURE_M)
    doubtful = ~sure & (((over > FLAT_M) & (clear > WALL_FLAT_M)) | ~surface.valid)
    return Foreground(sure, doubtful, inside)


def sharpened(rgb: NDArray[np.uint8], labels: Labels, doubtful: Bits) -> Labels:
    """Labelled bodies, grown into the doubtful pixels near them that have their colour."""
    bodies = labels > 0
    background = ~bodies & ~doubtful
    near = cv2.dilate(bodies.astype(np.uint8), _disc(REACH_PX)) > 0
    at = np.flatnonzero(doubtful & near & ~bodies)
    if not len(at) or not background.any():
        return labels
    colors = cv2.GaussianBlur(rgb, (3, 3), 0).reshape(-1, 3).astype(np.float32)
    body, ground = _nearest(bodies)[at], _nearest(background)[at]
    to_body = np.abs(colors[at] - colors[body]).sum(1)
    to_ground = np.abs(colors[at] - colors[ground]).sum(1)
    out = labels.ravel().copy()
    out[at] = np.where(to_body < to_ground, out[body], 0)
    return out.reshape(labels.shape)


def _nearest(of: Bits) -> NDArray[np.int64]:
    """(h w,) flat index of the nearest pixel of a mask."""
    _, zones = cv2.distanceTransformWithLabels(
        (~of).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    at = np.flatnonzero(of)
    owner = np.zeros(int(zones.max()) + 1, dtype=np.int64)
    owner[zones.ravel()[at]] = at
    nearest: NDArray[np.int64] = owner[zones.ravel()]
    return nearest


def _disc(radius: int) -> NDArray[np.uint8]:
    kernel: NDArray[np.uint8] = cv2.getStructuringElement(
        cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1)
    ).astype(np.uint8)
    return kernel
