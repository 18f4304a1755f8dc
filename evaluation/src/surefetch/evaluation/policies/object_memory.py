"""The scene graph that DovSG keeps: objects, what they are, and how they stand. Pure.

See `policies.dovsg`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.geometry import inverse, transform
from surefetch.common.hypotheses import RELATIONS, Relation, tracked
from surefetch.common.messages import ContainerReading, Track
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.voxels import N_VOXELS, Marks, Voxels, pose_of, voxel_at
from surefetch.evaluation.recordings.free_space import FILLED, FREE, SHAPE, Grid

LOOKS: Final = 2
"""Detections that a memory object needs while it is outside the current frame. Published value."""
DELETED: Final = 0.5
"""Share of its voxels without which a memory object is dropped. Published value."""
INSIDE: Final = 0.95
"""Share of its points in the container's hull that puts an object inside. Published value."""
SLACK: Final = 2
"""Voxel widths by which newer depth must lie behind a voxel to delete it. Published value."""


@dataclass(frozen=True, eq=False)
class Node:
    """An object in memory."""

    track: Track
    p: float
    """Belief that it is the target, however it stands."""
    edge: Relation
    """To the container, by its points."""
    confirmed: bool
    """It is in the current frame, or was detected often enough."""


def graph(now: Observation) -> list[Node]:
    """The objects that newer depth has not deleted, the older first."""
    grids = [look.grid() for look in now.looks]
    belief, step = now.believed.belief, now.believed.step
    return [
        Node(
            track=track,
            p=sum(belief[tracked(track.id, relation)] for relation in RELATIONS),
            edge=_edge(track, now.estimate.container),
            confirmed=track.last_step == step or track.n_observations >= LOOKS,
        )
        for track in now.believed.tracks
        if _deleted(track, grids[track.last_step + 1 :]) <= DELETED
    ]


def _edge(track: Track, container: ContainerReading | None) -> Relation:
    """By the points over the container's footprint; what stands in a tray looks out of it."""
    if container is None:
        return "outside"
    points_m = track.points_world_m.astype(np.float64)
    if not len(points_m):
        points_m = np.array([track.center_world_m])
    local_m = transform(inverse(pose_of(container.outer)), points_m)
    within = np.abs(local_m[:, :2]) <= np.asarray(container.outer.size_m[:2]) / 2.0
    return "inside" if within.all(axis=1).mean() >= INSIDE else "outside"


def _deleted(track: Track, newer: Sequence[Grid]) -> float:
    """Share of a track's voxels behind which newer depth has seen something."""
    voxels = np.unique(voxel_at(track.points_world_m.astype(np.float64)))
    voxels = voxels[voxels < N_VOXELS]
    if not len(voxels):
        return 0.0
    deleted = np.zeros(len(voxels), np.bool_)
    for grid in newer:
        deleted |= (grid.ravel()[voxels] == FREE) & ~_near_filled(grid, voxels)
    return float(deleted.mean())


def _near_filled(grid: Grid, voxels: Voxels) -> Marks:
    steps = np.mgrid[tuple(slice(-SLACK, SLACK + 1) for _ in SHAPE)].reshape(3, -1).T
    around = np.column_stack(np.unravel_index(voxels, SHAPE))[:, None] + steps
    i, j, k = np.moveaxis(np.clip(around, 0, np.subtract(SHAPE, 1)), -1, 0)
    near: Marks = (grid[i, j, k] == FILLED).any(axis=1)
    return near
