"""Which voxels no look has seen, and which of them an action is predicted to reveal: U(h). Pure.

A view is predicted to reveal what its rays reach before anything that is known to be filled:
voxels seen filled, walls and lid of the container, obstacles. Removing a cover is predicted to
reveal the inside of the container, and nothing else is while the cover is on.
"""

from dataclasses import dataclass
from functools import cache, cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import Cell, InformRow, View
from surefetch.common.geometry import Array, intrinsics, inverse, project, transform
from surefetch.common.messages import Track
from surefetch.common.viewpoint import camera_pose
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.voxels import (
    CENTERS_WORLD_M,
    N_VOXELS,
    Marks,
    Voxels,
    in_shadow,
    interior,
    near,
    voxel_at,
    within,
)
from surefetch.evaluation.recordings.free_space import FILLED, UNSEEN, VOXEL_M

STRIDE_PX: Final = 8
"""One ray for a square of so many pixels."""
LONGEST_RAY_M: Final = 1.5
CLOSE_M: Final = 0.02
NEAR_M: Final = 0.2
"""What is farther from a body than this is not told to be behind it. Source: RoboEXP, the distance
within which an object obstructs."""


@dataclass(frozen=True, eq=False)
class Outlook:
    """What is unseen now, and what may become of it."""

    now: Observation

    @cached_property
    def unseen(self) -> Marks:
        """What none of the looks so far saw."""
        marks: Marks = self.now.free_space.ravel() == UNSEEN
        return marks

    @cached_property
    def inside(self) -> Marks:
        """The inside of the container, as far as one is known."""
        marks = np.zeros(N_VOXELS, np.bool_)
        if self.now.estimate.container is not None:
            marks[interior(self.now.estimate.container)] = True
        return marks

    def revealed(self, row: InformRow) -> Marks:
        """U(h): the unseen voxels that an information action is predicted to reveal."""
        if row.kind == "remove_cover":
            return self.unseen & self.inside
        reached = _in_sight(_rays(self.now.cell, self.now.cell.view(row.view)), self._filled)
        in_sight = self.unseen & reached
        return in_sight & ~self.inside if self.now.cover == "covered" else in_sight

    def behind(self, track: Track) -> Voxels:
        """Unseen voxels near a track that it hid from one of the looks so far."""
        if track.solid is None:
            return np.zeros(0, np.intp)
        close = near(track.center_world_m, (NEAR_M, NEAR_M, NEAR_M))
        eyes_m = [camera_pose(self.now.cell, view)[:3, 3] for view in views_taken(self.now)]
        return in_shadow(track.solid, eyes_m, close[self.unseen[close]])

    def about(self, track: Track) -> Voxels:
        """Unseen voxels in and close about the box of a track, where its unseen faces are."""
        if track.solid is None:
            return np.zeros(0, np.intp)
        close = within(track.solid, CLOSE_M)
        return close[self.unseen[close]]

    @cached_property
    def _filled(self) -> Marks:
        """What was seen filled, and what is known to stand where no look has seen."""
        known = np.zeros(N_VOXELS, np.bool_)
        container = self.now.estimate.container
        if container is not None:
            known[within(container.outer)] = True
            known &= ~self.inside
            known[within(container.lid.plate, VOXEL_M / 2.0) if container.lid else []] = True
        for box in self.now.estimate.obstacles:
            known[within(box)] = True
        filled: Marks = (self.now.free_space.ravel() == FILLED) | (known & self.unseen)
        return filled


def views_taken(now: Observation) -> tuple[View, ...]:
    """The views that the camera was at, the first included."""
    names = [now.cell.views[0].name, *(now.cell.inform(name).view for name in sorted(now.used))]
    return tuple(now.cell.view(name) for name in dict.fromkeys(names))


@dataclass(frozen=True, eq=False)
class _Rays:
    """The rays of a camera through the grid."""

    passes: Voxels
    """(rays, steps): the voxel at each step; N_VOXELS outside the grid"""
    depth_m: NDArray[np.floating]
    """(steps,) along the optical axis"""
    ray_of: Voxels
    """(voxels,): the ray that passes nearest; the number of rays for what is not in the image"""
    voxel_depth_m: Array
    """(voxels,) along the optical axis"""


@cache
def _rays(cell: Cell, view: View) -> _Rays:
    camera, T_world_camera = cell.camera, camera_pose(cell, view)
    K = intrinsics(camera.width, camera.height, camera.vertical_fov_deg)
    columns, rows = -(-camera.width // STRIDE_PX), -(-camera.height // STRIDE_PX)
    v, u = np.mgrid[:rows, :columns].reshape(2, -1) * STRIDE_PX + (STRIDE_PX - 1) / 2.0
    ahead = np.column_stack([u, v, np.ones(len(u))]) @ np.linalg.inv(K).T
    depth_m = np.arange(VOXEL_M, LONGEST_RAY_M, VOXEL_M)
    steps_m = (ahead[:, None, :] * depth_m[:, None]).reshape(-1, 3)
    passes = voxel_at(transform(T_world_camera, steps_m)).reshape(len(u), -1)
    crossed = np.flatnonzero((passes < N_VOXELS).any(axis=0))
    kept = slice(crossed[0], crossed[-1] + 1)
    local_m = transform(inverse(T_world_camera), CENTERS_WORLD_M)
    in_front = local_m[:, 2] > 0.0
    seen_px = project(K, np.where(in_front[:, None], local_m, 1.0))
    at = np.floor((seen_px + 0.5) / STRIDE_PX).astype(np.intp)
    in_image = in_front & ((at >= 0) & (at < (columns, rows))).all(axis=1)
    ray_of = np.where(in_image, at[:, 1] * columns + at[:, 0], len(u)).astype(np.intp)
    return _Rays(passes[:, kept].copy(), depth_m[kept], ray_of, local_m[:, 2])


def _in_sight(rays: _Rays, filled: Marks) -> Marks:
    """Voxels that are in the image and not behind filled ones."""
    hits = np.append(filled, False)[rays.passes]
    depth_m = np.where(hits.any(axis=1), rays.depth_m[hits.argmax(axis=1)], np.inf)
    reach_m = np.append(depth_m, -np.inf)[rays.ray_of]
    in_sight: Marks = rays.voxel_depth_m <= reach_m + VOXEL_M / 2.0
    return in_sight
