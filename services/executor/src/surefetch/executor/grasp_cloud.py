"""From the perceived world to the points that a grasp proposer wants."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse, transform
from surefetch.common.messages import Estimate, Track
from surefetch.executor.obstacles import VOXEL_M, NamedBox, named, obstacles_of, track_name

SPACING_M = 0.008
"""Between sampled points of a box's faces."""
NEAR_M = 0.30
"""Nothing farther from the object can touch the hand."""
BEYOND_SOLID_M = 0.006
"""Points this far outside the perceived solid are no part of the object."""
_RING = 2.0 * np.pi * np.arange(48) / 48
_CORNERS = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5]), axis=-1).reshape(-1, 3)


def grasp_cloud(estimate: Estimate, track: Track) -> tuple[Array, NDArray[np.bool_]]:
    """Everything around a track as points (n, 3) in the world, and which of them are the track's.

    The track's own: what was seen of it, the same turned by 180 degrees about the axis of its
    solid (a single view sees only the near side, and upright objects look alike from behind), and
    the round column inside its solid. The rest: the faces of all that collision checks avoid.
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
    return transform(box.T_world_box, np.concatenate([local, turned, _column(box.size_m)]))


def _column(size_m: Array) -> Array:
    """The elliptic column inside a box (n, 3): inside every upright shape but a ball."""
    ring = np.column_stack([np.cos(_RING), np.sin(_RING)]) * size_m[:2] / 2.0
    levels = np.linspace(-0.5, 0.5, 5) * size_m[2]
    return np.concatenate([np.column_stack([ring, np.full(len(ring), z)]) for z in levels])


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
