"""Rigid transforms and the pinhole camera.

Frames read right to left: ``p_world = T_world_camera @ p_camera``. Camera axes are OpenCV's:
x right, y down, z forward. Lengths are metres, angles radians, image coordinates pixels with
pixel centres at whole numbers.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rigid(R: Array, t_m: Array) -> Array:
    """The (4, 4) transform with rotation R (3, 3) and translation t (3,)."""
    T = np.eye(4)
    T[:3, :3] = R
    T[:3, 3] = t_m
    return T


def inverse(T: Array) -> Array:
    """The inverse of a rigid (4, 4) transform."""
    R_t = T[:3, :3].T
    return rigid(R_t, -R_t @ T[:3, 3])


def transform(T_a_b: Array, points_b_m: Array) -> Array:
    """Points (n, 3) given in frame b, in frame a."""
    moved: Array = points_b_m @ T_a_b[:3, :3].T + T_a_b[:3, 3]
    return moved


def rotation_z(yaw_rad: float) -> Array:
    """Rotation (3, 3) by yaw about +z."""
    c, s = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def rotation_from_vector(rotvec_rad: Array) -> Array:
    """Rotation (3, 3) of a rotation vector, axis times angle (Rodrigues)."""
    angle = float(np.linalg.norm(rotvec_rad))
    x, y, z = rotvec_rad
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-12:
        R: Array = np.eye(3) + K
        return R
    K = K / angle
    R = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K)
    return R


def rotation_angle(R: Array) -> float:
    """The angle of a rotation (3, 3), in [0, pi]. Accurate near 0 too."""
    axis2 = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return float(np.arctan2(np.linalg.norm(axis2), np.trace(R) - 1.0))


def look_at(eye_m: Array, target_m: Array, up: Array) -> Array:
    """T_world_camera of a camera at eye that looks at target, image-up towards `up`."""
    z = (target_m - eye_m) / np.linalg.norm(target_m - eye_m)
    x = np.cross(z, up)
    x /= np.linalg.norm(x)
    return rigid(np.column_stack([x, np.cross(z, x), z]), np.asarray(eye_m, dtype=np.float64))


def project(K: Array, points_camera_m: Array) -> Array:
    """Pixels (n, 2) of points (n, 3) in the camera frame; z must be positive."""
    uvw = points_camera_m @ K.T
    pixels: Array = uvw[:, :2] / uvw[:, 2:3]
    return pixels


def deproject(K: Array, pixels: Array, depth_m: Array) -> Array:
    """Camera-frame points (n, 3) of pixels (n, 2) at depth (n,) along the optical axis."""
    x = (pixels[:, 0] - K[0, 2]) / K[0, 0] * depth_m
    y = (pixels[:, 1] - K[1, 2]) / K[1, 1] * depth_m
    return np.column_stack([x, y, depth_m])


def intrinsics(width: int, height: int, vertical_fov_deg: float) -> Array:
    """K (3, 3) of an ideal camera: square pixels, principal point in the middle of the image."""
    focal_px = height / 2.0 / np.tan(np.radians(vertical_fov_deg) / 2.0)
    return np.array(
        [
            [focal_px, 0.0, (width - 1) / 2.0],
            [0.0, focal_px, (height - 1) / 2.0],
            [0.0, 0.0, 1.0],
        ]
    )
