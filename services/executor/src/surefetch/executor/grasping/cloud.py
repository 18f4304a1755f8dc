"""From the perceived world to the points that a grasp proposer wants."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse, transform
from surefetch.common.messages import Estimate, Track
from surefetch.executor.motion.obstacles import VOXEL_M, NamedBox, named, obstacles_of, track_name

SPACING_M = 0.008
"""Between sampled points of a box's faces."""
NEAR_M = 0.30
"""Nothing farther from the object can touch the hand."""
BEYOND_SOLID_M = 0.006
"""Points this far outside the perceived solid are no part of the object."""
CORNER_POINTS_MIN = 60
CORNER_FROM = 0.8
CORNER_SHARE = 0.01
"""Of the points seen from above, a full rectangle has 4 percent beyond 0.8 of both half lengths; a
disc, an ellipse and a hexagon have none."""
LEVELS = 5
_ANGLES = 2.0 * np.pi * np.arange(48) / 48
_ROUND = 0.5 * np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])
_SQUARE = _ROUND / (2.0 * np.abs(_ROUND).max(axis=1, keepdims=True))
_CORNERS = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5]), axis=-1).reshape(-1, 3)


def grasp_cloud(estimate: Estimate, track: Track) -> tuple[Array, NDArray[np.bool_]]:
    """Everything around a track as points (n, 3) in the world, and which of them are the track's.

    The track's own: what was seen of it; the same turned by 180 degrees about the axis of its
    solid, since a single view sees only the near side and upright objects look alike from behind;
    and the sides of its solid, of the box, or of the round column in it where no corners were
    seen. The rest: the faces of all that collision checks avoid.
    """
    own = _completed(track)
    center = own.mean(axis=0)
    others = _surroundings(estimate, track)
    near = np.linalg.norm(others[:, :2] - center[:2], axis=1) < NEAR_M
    points = np.concatenate([own, others[near]])
    mask = np.zeros(len(points), dtype=np.bool_)
    mask[: len(own)] = True
    return points, mask


def _completed(track: Track) -> Array:
    seen = np.asarray(track.points_world_m, dtype=np.float64)
    if track.solid is None:
        return seen
    box = named(track_name(track.id), track.solid)
    local = transform(inverse(box.T_world_box), seen)
    local = local[(np.abs(local) < box.size_m / 2.0 + BEYOND_SOLID_M).all(axis=1)]
    turned = local * [-1.0, -1.0, 1.0]
    column = _column(_SQUARE if _has_corners(local[:, :2]) else _ROUND, box.size_m)
    return transform(box.T_world_box, np.concatenate([local, turned, column]))


def _has_corners(seen_m: Array) -> bool:
    """Whether points (n, 2) fill the corners of their own extents, as no round body's do."""
    if len(seen_m) < CORNER_POINTS_MIN:
        return True
    low, high = np.quantile(seen_m, [0.02, 0.98], axis=0)
    off = np.abs(seen_m - (low + high) / 2.0) / np.maximum((high - low) / 2.0, 1e-6)
    return bool((off > CORNER_FROM).all(axis=1).mean() > CORNER_SHARE)


def _column(outline: Array, size_m: Array) -> Array:
    """The sides (n, 3) of a column inside a box, of an outline (m, 2) in units of its sizes."""
    flat = outline * size_m[:2]
    levels = np.linspace(-0.5, 0.5, LEVELS) * size_m[2]
    return np.concatenate([np.column_stack([flat, np.full(len(flat), z)]) for z in levels])


def _surroundings(estimate: Estimate, track: Track) -> Array:
    around = obstacles_of(estimate, ignore_tracks=(track.id,))
    cubes = (around.voxels_world_m[:, None] + VOXEL_M * _CORNERS).reshape(-1, 3)
    return np.concatenate([np.zeros((0, 3)), *(_faces(box) for box in around.boxes), cubes])


def _faces(box: NamedBox) -> Array:
    """Points (n, 3) on the surface of a box, at most SPACING_M apart along its edges."""
    steps: Sequence[Array] = [
        np.linspace(-v / 2.0, v / 2.0, max(int(np.ceil(v / SPACING_M)), 1) + 1) for v in box.size_m
    ]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    outside = (np.abs(grid) > box.size_m / 2.0 - 1e-9).any(axis=1)
    return transform(box.T_world_box, grid[outside])
