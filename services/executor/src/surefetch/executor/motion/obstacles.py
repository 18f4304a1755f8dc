"""What the arm must not touch, as named boxes made from what was perceived."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse, rigid, rotation_z, transform
from surefetch.common.messages import Box3d, ContainerReading, Estimate, Track

VOXEL_M = 0.010
EXPLAINED_M = 0.012
"""Surface points this near to a known box belong to it."""
TABLE_NOISE_M = 0.006
THIN_M = 0.004
"""Floors and walls are at least this thick."""


@dataclass(frozen=True, eq=False)
class NamedBox:
    """A solid box in the world; its name appears in refusals and in allowed pairs."""

    name: str
    T_world_box: Array
    """(4, 4), at the box's centre"""
    size_m: Array
    """(3,) full lengths"""


@dataclass(frozen=True, eq=False)
class Obstacles:
    """Boxes, and small cubes where a surface was seen that no box explains."""

    boxes: tuple[NamedBox, ...]
    voxels_world_m: Array
    """(n, 3) centres of cubes of VOXEL_M"""


def track_name(track: int) -> str:
    """How a track's box is called."""
    return f"track {track}"


def named(name: str, box: Box3d) -> NamedBox:
    """A perceived box under a name."""
    T = rigid(rotation_z(box.yaw_rad), np.asarray(box.center_world_m))
    return NamedBox(name, T, np.maximum(np.asarray(box.size_m), THIN_M))


def obstacles_of(
    estimate: Estimate, ignore_tracks: Sequence[int] = (), *, lid: bool = True
) -> Obstacles:
    """The perceived world as obstacles.

    Tracks become `track N`; the container `container floor` and four `container wall …`; its lid
    `lid` and `lid knob`; other bodies `obstacle N`. A container cut by the image border still
    counts as far as it was seen. A box in which a track stands is that body seen badly, or was put
    around something hollow: it is left out, so that what was seen of it counts point by point.

    Args:
        estimate: What was perceived.
        ignore_tracks: Tracks left out, points and all: what is about to be grasped or is held.
        lid: False leaves the lid out, when it is about to be grasped or is held.
    """
    boxes = [
        named(track_name(track.id), track.solid)
        for track in estimate.tracks
        if track.solid is not None and track.id not in ignore_tracks
    ]
    if estimate.container is not None:
        boxes += container_boxes(estimate.container)
        boxes += _lid_boxes(estimate.container) if lid else []
    others = [named(f"obstacle {i}", box) for i, box in enumerate(estimate.obstacles)]
    boxes += [box for box in others if not _holds_a_track(box, estimate.tracks)]
    left_out = [
        named(track_name(track.id), track.solid)
        for track in estimate.tracks
        if track.solid is not None and track.id in ignore_tracks
    ]
    if estimate.container is not None and not lid:
        left_out += _lid_boxes(estimate.container)
    points = np.asarray(estimate.obstacle_points_world_m, dtype=np.float64)
    unexplained = _beyond(points, [*boxes, *left_out])
    return Obstacles(tuple(boxes), voxels_of(unexplained))


def container_boxes(container: ContainerReading) -> list[NamedBox]:
    """Floor and four walls of a perceived container, up to its rim."""
    outer = named("container", container.outer)
    half_x, half_y = outer.size_m[0] / 2.0, outer.size_m[1] / 2.0
    bottom = outer.T_world_box[2, 3] - outer.size_m[2] / 2.0
    height = max(container.rim_z_m - bottom, THIN_M)
    wall_x = max(half_x - container.inner_size_m[0] / 2.0, THIN_M)
    wall_y = max(half_y - container.inner_size_m[1] / 2.0, THIN_M)
    z = bottom + height / 2.0 - outer.T_world_box[2, 3]
    floor = max(container.floor_z_m - bottom, THIN_M)
    floor_z = bottom + floor / 2.0 - outer.T_world_box[2, 3]
    long_x, long_y = (wall_x, 2.0 * half_y, height), (2.0 * half_x, wall_y, height)
    parts = {
        "container floor": ((0.0, 0.0, floor_z), (2.0 * half_x, 2.0 * half_y, floor)),
        "container wall +x": ((half_x - wall_x / 2.0, 0.0, z), long_x),
        "container wall -x": ((wall_x / 2.0 - half_x, 0.0, z), long_x),
        "container wall +y": ((0.0, half_y - wall_y / 2.0, z), long_y),
        "container wall -y": ((0.0, wall_y / 2.0 - half_y, z), long_y),
    }
    return [
        NamedBox(name, outer.T_world_box @ rigid(np.eye(3), np.array(center)), np.array(size))
        for name, (center, size) in parts.items()
    ]


def _holds_a_track(box: NamedBox, tracks: Sequence[Track]) -> bool:
    """Whether the middle of a track is inside the box."""
    if not tracks:
        return False
    centers = np.array([track.center_world_m for track in tracks])
    local = np.abs(transform(inverse(box.T_world_box), centers))
    return bool((local < box.size_m / 2.0).all(axis=1).any())


def _lid_boxes(container: ContainerReading) -> list[NamedBox]:
    if container.lid is None:
        return []
    knob = container.lid.knob
    boxes = [named("lid", container.lid.plate)]
    return boxes + ([named("lid knob", knob)] if knob is not None else [])


def _beyond(points_world_m: Array, boxes: Sequence[NamedBox]) -> Array:
    """The points (n, 3) that lie farther than EXPLAINED_M outside every box."""
    far: NDArray[np.bool_] = np.ones(len(points_world_m), dtype=bool)
    for box in boxes:
        local = np.abs(transform(inverse(box.T_world_box), points_world_m))
        far &= (local > box.size_m / 2.0 + EXPLAINED_M).any(axis=1)
    left: Array = points_world_m[far]
    return left


def voxels_of(points_world_m: Array) -> Array:
    """Centres (n, 3) of the cubes of VOXEL_M that hold a point clearly above the table."""
    standing = points_world_m[points_world_m[:, 2] > TABLE_NOISE_M]
    cells = np.unique(np.floor(standing / VOXEL_M).astype(np.int64), axis=0)
    centers: Array = (cells + 0.5).astype(np.float64) * VOXEL_M
    return centers
