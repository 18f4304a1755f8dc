"""The UR10e, the RG6 gripper and the wrist camera as tables: kinematics, limits, envelopes.

Everything that needs the robot's geometry is derived from here: the URDF that PyBullet and placo
read, the inverse kinematics and the collision shapes.

Frames: `base_link` is the world; the controller's `base` is turned by 180 degrees about z against
it. `tool0` is the flange, z out of it. The gripper closes along tool0's y. `tcp` is the point
midway between the fingertips' ends, its axes parallel to tool0's.

Sources: Universal Robots, "DH Parameters for calculations of kinematics and dynamics";
Universal_Robots_ROS2_Description, config/ur10e. RG6: tonydle/OnRobot_ROS2_Description.
"""

from dataclasses import dataclass

import numpy as np

from surefetch.common.cell import Camera
from surefetch.common.geometry import Array, rigid, rotation_from_vector

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
LINKS = ("base_link", "shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3", "tool0")
"""Frames of `link_frames`, in order. Link i turns with joint i; `tool0` is fixed to wrist_3."""

DH_A_M = np.array([0.0, -0.6127, -0.57155, 0.0, 0.0, 0.0])
DH_D_M = np.array([0.1807, 0.0, 0.0, 0.17415, 0.11985, 0.11655])
DH_ALPHA_RAD = np.array([np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0])

Q_MAX_RAD = np.radians([360.0, 360.0, 180.0, 360.0, 360.0, 360.0])
"""Symmetric joint limits. The elbow's is UR's own for planning: the links make more unreachable."""
QD_MAX_RAD_S = np.radians([120.0, 120.0, 180.0, 180.0, 180.0, 180.0])
TORQUE_MAX_NM = np.array([330.0, 330.0, 150.0, 54.0, 54.0, 54.0])
LINK_MASS_KG = np.array([7.369, 13.051, 3.989, 2.1, 1.98, 0.615])
LINK_COM_DH_M = np.array(
    [
        [0.021, 0.0, 0.027],
        [0.38, 0.0, 0.158],
        [0.24, 0.0, 0.068],
        [0.0, 0.007, 0.018],
        [0.0, 0.007, 0.018],
        [0.0, 0.0, -0.026],
    ]
)
"""(6, 3) centres of mass in the DH link frames."""

GRIPPER_MASS_KG = 1.01
FINGER_MASS_KG = 0.12
CAMERA_MASS_KG = 1.15
"""Zivid 2 with its on-arm mount."""

WIDTH_MAX_M = 0.160
GRIPPER_SPEED_M_S = 0.12
"""Of the opening; each finger has half of it."""
TIP_Z_M = 0.268
"""Flange to the ends of the closed fingertips."""
FINGER_LENGTH_M = 0.108
FINGER_BREADTH_M = 0.030
FINGER_THICKNESS_M = 0.015
CRANK_M = 0.080
CRANK_CLOSED_RAD = float(np.radians(-5.3))


@dataclass(frozen=True)
class Cylinder:
    """Round envelope of a link: centre and axis ("x", "y" or "z") in the link's frame."""

    name: str
    link: str
    center_m: tuple[float, float, float]
    axis: str
    radius_m: float
    length_m: float


@dataclass(frozen=True)
class Box:
    """Box envelope of a link, parallel to the link's frame."""

    name: str
    link: str
    center_m: tuple[float, float, float]
    size_m: tuple[float, float, float]


Solid = Cylinder | Box

ARM_SHAPES: tuple[Solid, ...] = (
    Cylinder("base", "base_link", (0.0, 0.0, 0.045), "z", 0.095, 0.09),
    Cylinder("shoulder", "shoulder", (0.0, 0.0, 0.1807), "z", 0.085, 0.17),
    Cylinder("shoulder side", "shoulder", (0.0, 0.0, 0.1807), "y", 0.085, 0.19),
    Cylinder("upper arm", "upper_arm", (-0.30635, 0.0, 0.176), "x", 0.065, 0.6127),
    Cylinder("upper arm root", "upper_arm", (0.0, 0.0, 0.176), "z", 0.085, 0.17),
    Cylinder("upper arm elbow", "upper_arm", (-0.6127, 0.0, 0.176), "z", 0.072, 0.15),
    Cylinder("forearm", "forearm", (-0.285775, 0.0, 0.045), "x", 0.052, 0.57155),
    Cylinder("forearm elbow", "forearm", (0.0, 0.0, 0.045), "z", 0.066, 0.14),
    Cylinder("forearm wrist", "forearm", (-0.57155, 0.0, 0.045), "z", 0.058, 0.11),
    Cylinder("wrist 1", "wrist_1", (0.0, 0.0, 0.165), "z", 0.058, 0.135),
    Cylinder("wrist 1 cross", "wrist_1", (0.0, 0.0, 0.17415), "y", 0.058, 0.12),
    Cylinder("wrist 2", "wrist_2", (0.0, 0.0, 0.11), "z", 0.058, 0.135),
    Cylinder("wrist 2 cross", "wrist_2", (0.0, 0.0, 0.11985), "y", 0.058, 0.12),
    Cylinder("wrist 3", "wrist_3", (0.0, 0.0, 0.0885), "z", 0.045, 0.056),
)
"""Hand-picked envelopes in the link frames; conservative, not the maker's meshes."""

GRIPPER_SHAPES: tuple[Solid, ...] = (
    Cylinder("gripper mount", "tool0", (0.0, 0.0, 0.02), "z", 0.037, 0.04),
    Box("gripper body", "tool0", (0.0, 0.0, 0.10), (0.065, 0.11, 0.12)),
)

FINGER_SIZE_M = (FINGER_BREADTH_M, FINGER_THICKNESS_M, FINGER_LENGTH_M)
CAMERA_BODY = Box("camera body", "camera_optical", (0.0555, 0.0, -0.05), (0.17, 0.06, 0.12))
"""Zivid 2: the lens sits 55 mm beside the middle, the projector is on its +x side."""


def dh_constant(i: int) -> Array:
    """C_i (4, 4): the part of joint i's standard DH transform after its rotation, i from 0."""
    c, s = np.cos(DH_ALPHA_RAD[i]), np.sin(DH_ALPHA_RAD[i])
    R = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    return rigid(np.round(R, 15), np.array([DH_A_M[i], 0.0, DH_D_M[i]]))


T_BASE_LINK_BASE = np.diag([-1.0, -1.0, 1.0, 1.0])
JOINT_ORIGINS = np.array([T_BASE_LINK_BASE, *(dh_constant(i) for i in range(6))])
"""(7, 4, 4): where joint i turns, in its parent link; the last is tool0 in wrist_3."""


def link_frames(q_rad: Array) -> Array:
    """Frames of `LINKS` in base_link, (..., 8, 4, 4), for joints (..., 6)."""
    q_rad = np.asarray(q_rad, dtype=np.float64)
    c, s = np.cos(q_rad)[..., None], np.sin(q_rad)[..., None]
    steps = np.broadcast_to(JOINT_ORIGINS[:6], (*q_rad.shape, 4, 4)).copy()
    x, y = JOINT_ORIGINS[:6, :, 0], JOINT_ORIGINS[:6, :, 1]
    steps[..., :, 0] = c * x + s * y
    steps[..., :, 1] = c * y - s * x
    frames = np.empty((*q_rad.shape[:-1], 8, 4, 4))
    frames[..., 0, :, :] = np.eye(4)
    frames[..., 1, :, :] = steps[..., 0, :, :]
    for i in range(1, 6):
        frames[..., i + 1, :, :] = frames[..., i, :, :] @ steps[..., i, :, :]
    frames[..., 7, :, :] = frames[..., 6, :, :] @ JOINT_ORIGINS[6]
    return frames


def flange(q_rad: Array) -> Array:
    """T_world_flange (..., 4, 4) of joints (..., 6)."""
    frames: Array = link_frames(q_rad)[..., 7, :, :]
    return frames


def retraction_m(width_m: float | Array) -> Array:
    """How far the fingertips draw back towards the flange at an opening, against closed.

    The fingers swing on parallel cranks. A model that gives the published stroke and the reported
    46 mm at full opening; it is not the maker's table.
    """
    sine = np.asarray(width_m) / 2.0 / CRANK_M + np.sin(CRANK_CLOSED_RAD)
    drawn: Array = np.asarray(CRANK_M * (np.cos(CRANK_CLOSED_RAD) - np.sqrt(1.0 - sine**2)))
    return drawn


def tcp(width_m: float) -> Array:
    """T_flange_tcp (4, 4) at an opening: midway between the fingertips' ends."""
    return rigid(np.eye(3), np.array([0.0, 0.0, TIP_Z_M - float(retraction_m(width_m))]))


def finger_centers(width_m: float) -> tuple[Array, Array]:
    """Centres (3,) of the left (+y) and right finger boxes in the flange frame."""
    y = width_m / 2.0 + FINGER_THICKNESS_M / 2.0
    z = TIP_Z_M - FINGER_LENGTH_M / 2.0 - float(retraction_m(width_m))
    return np.array([0.0, y, z]), np.array([0.0, -y, z])


def camera_mount(camera: Camera) -> Array:
    """T_flange_camera (4, 4) of a cell file's camera."""
    R = rotation_from_vector(np.radians(camera.T_flange_camera_rotvec_deg))
    return rigid(R, np.asarray(camera.T_flange_camera_position_m))
