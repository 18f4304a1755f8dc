"""Which voxels of the free-space grid lie in a box, in its shadow, or at a point. Pure.

Voxels are those of `recordings.free_space`, named by their place in the raveled grid.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse, rigid, rotation_z, transform
from surefetch.common.messages import Box3d, ContainerReading
from surefetch.evaluation.recordings.free_space import (
    ORIGIN_WORLD_M,
    SHAPE,
    VOXEL_M,
    centers_world_m,
)

Marks = NDArray[np.bool_]
"""(nx·ny·nz,), true for the voxels that are meant"""
Voxels = NDArray[np.intp]
"""(n,), numbers of voxels"""

N_VOXELS: Final = int(np.prod(SHAPE))
CENTERS_WORLD_M: Final = centers_world_m()
_NUMBERS: Final = np.arange(N_VOXELS, dtype=np.intp).reshape(SHAPE)
VOXEL_L: Final = 1e3 * VOXEL_M**3


def within(box: Box3d, margin_m: float = 0.0) -> Voxels:
    """Voxels whose centres lie in a box that is grown by a margin on every side."""
    half_m = np.asarray(box.size_m) / 2.0 + margin_m
    close = near(box.center_world_m, np.abs(pose_of(box)[:3, :3]) @ half_m)
    return close[_inside(_in_frame_of(box, close), half_m)]


def interior(container: ContainerReading) -> Voxels:
    """Voxels between the walls of a container, from its floor to its rim."""
    x_m, y_m, _ = container.outer.center_world_m
    z_m = (container.floor_z_m + container.rim_z_m) / 2.0
    size_m = (*container.inner_size_m, container.rim_z_m - container.floor_z_m)
    return within(
        Box3d(center_world_m=(x_m, y_m, z_m), size_m=size_m, yaw_rad=container.outer.yaw_rad)
    )


def near(center_world_m: Sequence[float], reach_m: Sequence[float] | Array) -> Voxels:
    """Voxels that are no farther from a point than so much along each axis."""
    axes = []
    for at_m, by_m, low_m, n in zip(center_world_m, reach_m, ORIGIN_WORLD_M, SHAPE, strict=True):
        first = int(np.floor((at_m - by_m - low_m) / VOXEL_M))
        last = int(np.ceil((at_m + by_m - low_m) / VOXEL_M))
        axes.append(np.arange(max(first, 0), min(last, n)))
    numbers: Voxels = _NUMBERS[np.ix_(*axes)].ravel()
    return numbers


def in_shadow(box: Box3d, eyes_world_m: Sequence[Array], voxels: Voxels) -> Voxels:
    """Which of these voxels a box hides from one of these points (3,); its own inside not."""
    T_box_world, half_m = inverse(pose_of(box)), np.asarray(box.size_m) / 2.0
    local_m = _in_frame_of(box, voxels)
    hidden = np.zeros(len(voxels), np.bool_)
    for eye_m in eyes_world_m:
        hidden |= _crosses(transform(T_box_world, eye_m[None])[0], local_m, half_m)
    return voxels[hidden & ~_inside(local_m, half_m)]


def voxel_at(points_world_m: Array) -> Voxels:
    """The voxel of each point (n, 3); N_VOXELS outside the grid."""
    at = np.floor((points_world_m - np.asarray(ORIGIN_WORLD_M)) / VOXEL_M).astype(np.intp)
    inside: Marks = ((at >= 0) & (at < np.asarray(SHAPE))).all(axis=1)
    i, j, k = np.where(inside[:, None], at, 0).T
    return np.where(inside, np.ravel_multi_index((i, j, k), SHAPE), N_VOXELS).astype(np.intp)


def pose_of(box: Box3d) -> Array:
    """T_world_box (4, 4)."""
    return rigid(rotation_z(box.yaw_rad), np.asarray(box.center_world_m))


def _in_frame_of(box: Box3d, voxels: Voxels) -> Array:
    """Centres (3, n) in the axes of a box."""
    return transform(inverse(pose_of(box)), CENTERS_WORLD_M[voxels]).T


def _inside(local_m: Array, half_m: Array) -> Marks:
    x_m, y_m, z_m = np.abs(local_m)
    inside: Marks = (x_m <= half_m[0]) & (y_m <= half_m[1]) & (z_m <= half_m[2])
    return inside


def _crosses(eye_m: Array, points_m: Array, half_m: Array) -> Marks:
    """Whether the way from the eye to each point, (3, n), crosses the box about the origin.

    Source: Kay and Kajiya, Ray tracing complex scenes (1986), slabs.
    """
    enters, leaves = np.zeros(points_m.shape[1]), np.ones(points_m.shape[1])
    for eye, points, half in zip(eye_m, points_m, half_m, strict=True):
        ways = points - eye
        ways[np.abs(ways) < 1e-12] = 1e-12
        to_low, to_high = (-half - eye) / ways, (half - eye) / ways
        enters = np.maximum(enters, np.minimum(to_low, to_high))
        leaves = np.minimum(leaves, np.maximum(to_low, to_high))
    crosses: Marks = enters <= leaves
    return crosses
