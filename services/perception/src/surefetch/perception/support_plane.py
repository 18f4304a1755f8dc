"""The plane that things stand on, found in a cloud of points. Pure."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.geometry import Array, rigid

INLIER_M: Final = 0.006
MIN_SHARE: Final = 0.08
"""A support shows at least this share of the points."""
MAX_TILT_KNOWN_POSE: Final = float(np.cos(np.deg2rad(4.0)))
N_TRIPLES: Final = 200
SNAP_M: Final = 0.015
"""A support this near to z = 0 of a known pose is z = 0: the rest is the pose's error."""


@dataclass(frozen=True, eq=False)
class Plane:
    """Points p with normal · p + offset_m = 0; the normal points to the side of the camera."""

    normal: Array
    offset_m: float
    share: float
    """Share of the points within 6 mm."""

    def heights(self, points_m: Array) -> Array:
        """(n,) signed distances of points (n, 3)."""
        out: Array = points_m @ self.normal + self.offset_m
        return out


def find_plane(
    points_m: Array, *, up: Array, min_cosine: float, rng: np.random.Generator
) -> Plane | None:
    """The plane with most points whose normal is within an angle of `up` (RANSAC, then refined).

    Args:
        points_m: (n, 3), any frame.
        up: (3,) unit vector.
        min_cosine: the least cosine between the normal and `up`.
        rng: for the triples.

    Returns:
        None when no plane holds enough of the points.
    """
    if len(points_m) < 50:
        return None
    corners = points_m[rng.integers(0, len(points_m), size=(N_TRIPLES, 3))]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals / np.maximum(lengths, 1e-12)[:, None]
    normals *= np.where(normals @ up < 0.0, -1.0, 1.0)[:, None]
    allowed = (lengths > 1e-6) & (normals @ up >= min_cosine)
    if not allowed.any():
        return None
    normals, origins = normals[allowed], corners[allowed, 0]
    offsets = -np.einsum("ij,ij->i", normals, origins)
    counts = (np.abs(points_m @ normals.T + offsets) < INLIER_M).sum(0)
    best = int(np.argmax(counts))
    return _refined(points_m, normals[best], float(offsets[best]), up, min_cosine)


def _refined(
    points_m: Array, normal: Array, offset_m: float, up: Array, min_cosine: float
) -> Plane | None:
    for tolerance_m in (INLIER_M, INLIER_M, 0.6 * INLIER_M):
        near = points_m[np.abs(points_m @ normal + offset_m) < tolerance_m]
        if len(near) < 30:
            return None
        middle = near.mean(0)
        normal = np.linalg.svd(np.cov((near - middle).T))[0][:, 2]
        normal = normal if normal @ up > 0 else -normal
        offset_m = -float(normal @ middle)
    share = float((np.abs(points_m @ normal + offset_m) < INLIER_M).mean())
    if share < MIN_SHARE or normal @ up < min_cosine:
        return None
    return Plane(normal, offset_m, share)


def find_support(points_camera_m: Array, T_world_camera: Array | None) -> Plane | None:
    """The support in the camera frame.

    With a pose, up is world z. Without, any plane that the camera looks down on will do: a wall
    seen by a camera that looks downwards faces away from image-up, a table never does.
    """
    rng = np.random.default_rng(0)
    if T_world_camera is not None:
        up, min_cosine = T_world_camera[2, :3].copy(), MAX_TILT_KNOWN_POSE
        return find_plane(points_camera_m, up=up, min_cosine=min_cosine, rng=rng)
    straight_down = np.array([0.0, 0.0, -1.0])
    slanted = np.array([0.0, -np.sin(0.9), -np.cos(0.9)])
    planes = [
        find_plane(points_camera_m, up=slanted, min_cosine=float(np.cos(0.85)), rng=rng),
        find_plane(points_camera_m, up=straight_down, min_cosine=float(np.cos(0.3)), rng=rng),
    ]
    found = [plane for plane in planes if plane is not None]
    return max(found, key=lambda plane: plane.share) if found else None


def levelled(plane: Plane, T_world_camera: Array | None) -> tuple[Array, float]:
    """T_world_camera turned so that the support is level, and the support's z in that world.

    A known pose is turned by no more than its own error; without one the world's origin is the
    foot of the camera, x points along the view.
    """
    if T_world_camera is None:
        z = plane.normal
        x = np.array([0.0, 0.0, 1.0]) - z[2] * z
        if np.linalg.norm(x) < 1e-3:
            x = np.array([0.0, -1.0, 0.0]) - (-z[1]) * z
        x = x / np.linalg.norm(x)
        R = np.stack([x, np.cross(z, x), z])
        return rigid(R, np.array([0.0, 0.0, plane.offset_m])), 0.0
    normal_world = T_world_camera[:3, :3] @ plane.normal
    axis = np.cross(normal_world, [0.0, 0.0, 1.0])
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    R = np.eye(3) + skew + skew @ skew / (1.0 + normal_world[2])
    t = T_world_camera[:3, 3]
    support_z = float(t[2] - plane.offset_m)
    snapped = 0.0 if abs(support_z) < SNAP_M else support_z
    aim = t + T_world_camera[:3, 2] * abs(plane.offset_m / min(-0.1, T_world_camera[2, 2]))
    moved = aim + R @ (t - aim)
    moved[2] = plane.offset_m + snapped
    return rigid(R @ T_world_camera[:3, :3], moved), snapped
