"""The robot as URDF text, generated from the tables of `ur10e`: one source for every reader.

Joints in order: the six of the arm; the retraction, which carries both fingers and draws them
back by `ur10e.retraction_m(width)`; the left (+y) and the right finger, each at half the opening.
Frames: `base`, `tool0`, `tcp` (rides on the retraction), `camera_optical`.
"""

import numpy as np

from surefetch.common.geometry import Array
from surefetch.executor.robot import ur10e

FINGER_JOINTS = ("left_finger_joint", "right_finger_joint")
RETRACTION_JOINT = "finger_retraction_joint"
FRAME_MASS_KG = 1e-4
FRAME_INERTIA = 1e-7
LIGHT = "0.78 0.79 0.81 1"
DARK = "0.25 0.27 0.30 1"
BLUE = "0.30 0.55 0.75 1"


def robot_urdf(T_flange_camera: Array) -> str:
    """URDF of arm, gripper and camera, the camera hung at T_flange_camera (4, 4).

    Frame-only links carry a tiny inertia, because PyBullet gives 1 kg to a link without one.
    """
    parts = [_link("base_link", 4.0, _com_of("base_link"), LIGHT), _frame("base")]
    parts.append(_fixed("base", "base_link", ur10e.T_BASE_LINK_BASE))
    for i, name in enumerate(ur10e.LINKS[1:7]):
        com = (ur10e.dh_constant(i) @ np.append(ur10e.LINK_COM_DH_M[i], 1.0))[:3]
        parts.append(_link(name, ur10e.LINK_MASS_KG[i], com, LIGHT if i % 2 else BLUE))
        parts.append(_revolute(i, name))
    parts.append(_link("tool0", ur10e.GRIPPER_MASS_KG, np.array([0.0, 0.0, 0.10]), DARK))
    parts.append(_fixed("tool0", "wrist_3", ur10e.JOINT_ORIGINS[6]))
    parts += _gripper()
    parts.append(_camera())
    parts.append(_fixed("camera_optical", "tool0", T_flange_camera))
    body = "\n".join(parts)
    return f'<?xml version="1.0"?>\n<robot name="ur10e_rg6">\n{body}\n</robot>\n'


def _gripper() -> list[str]:
    """Retraction carriage, two fingers and the tcp frame."""
    left, right = ur10e.finger_centers(0.0)
    down = np.eye(4)
    down[2, 3] = ur10e.TIP_Z_M
    parts = [_link("finger_carriage", 0.01, np.zeros(3), DARK)]
    parts.append(
        _prismatic(RETRACTION_JOINT, "tool0", "finger_carriage", "0 0 -1", (-0.002, 0.05), 2000.0)
    )
    for name, center, axis in (("left_finger", left, "0 1 0"), ("right_finger", right, "0 -1 0")):
        box = ur10e.Box(name, name, _triple(center), ur10e.FINGER_SIZE_M)
        parts.append(_link(name, ur10e.FINGER_MASS_KG, center, DARK, (box,)))
        parts.append(_prismatic(f"{name}_joint", "finger_carriage", name, axis, (0.0, 0.08), 120.0))
    parts.append(_frame("tcp"))
    parts.append(_fixed("tcp", "finger_carriage", down))
    return parts


def _camera() -> str:
    box = ur10e.CAMERA_BODY
    return _link("camera_optical", ur10e.CAMERA_MASS_KG, np.asarray(box.center_m), DARK, (box,))


def _shapes_of(link: str) -> tuple[ur10e.Solid, ...]:
    return tuple(s for s in ur10e.ARM_SHAPES + ur10e.GRIPPER_SHAPES if s.link == link)


def _com_of(link: str) -> Array:
    return np.mean([s.center_m for s in _shapes_of(link)], axis=0)  # type: ignore[no-any-return]


def _link(
    name: str,
    mass_kg: float,
    com_m: Array,
    rgba: str,
    shapes: tuple[ur10e.Solid, ...] | None = None,
) -> str:
    """A link with inertia and its envelopes, once to see and once to touch."""
    solids = _shapes_of(name) if shapes is None else shapes
    lines = [f'  <link name="{name}">', _inertial(mass_kg, com_m, solids)]
    for solid in solids:
        where = _origin(_pose_of(solid))
        shape = f"{where}<geometry>{_geometry(solid)}</geometry>"
        lines.append(
            f'    <visual>{shape}<material name="{name}"><color rgba="{rgba}"/></material></visual>'
        )
        lines.append(f"    <collision>{shape}</collision>")
    return "\n".join([*lines, "  </link>"])


def _frame(name: str) -> str:
    """A link that is only a frame."""
    inertia = _inertia_tag(FRAME_INERTIA, FRAME_INERTIA, FRAME_INERTIA)
    mass = f'<mass value="{FRAME_MASS_KG}"/>'
    return f'  <link name="{name}">\n    <inertial>{mass}{inertia}</inertial>\n  </link>'


def _inertial(mass_kg: float, com_m: Array, solids: tuple[ur10e.Solid, ...]) -> str:
    """Mass, centre of mass, and the inertia of a solid box as large as the largest envelope."""
    sizes = [_extents(s) for s in solids] or [np.full(3, 0.05)]
    x, y, z = max(sizes, key=lambda size: float(np.prod(size)))
    ixx, iyy, izz = (mass_kg / 12.0 * v for v in (y * y + z * z, x * x + z * z, x * x + y * y))
    where = f'<origin xyz="{_numbers(com_m)}" rpy="0 0 0"/>'
    tag = _inertia_tag(ixx, iyy, izz)
    return f'    <inertial>{where}<mass value="{mass_kg:.17g}"/>{tag}</inertial>'


def _inertia_tag(ixx: float, iyy: float, izz: float) -> str:
    return f'<inertia ixx="{ixx:.9g}" ixy="0" ixz="0" iyy="{iyy:.9g}" iyz="0" izz="{izz:.9g}"/>'


def _extents(solid: ur10e.Solid) -> Array:
    """Full sizes (3,) along the link's axes."""
    if isinstance(solid, ur10e.Box):
        return np.asarray(solid.size_m)
    size = np.full(3, 2.0 * solid.radius_m)
    size["xyz".index(solid.axis)] = solid.length_m
    return size


def _pose_of(solid: ur10e.Solid) -> Array:
    T = solid_rotation(solid)
    T[:3, 3] = solid.center_m
    return T


def solid_rotation(solid: ur10e.Solid) -> Array:
    """(4, 4) rotation that turns z, the axis of URDF and FCL cylinders, into the solid's axis."""
    T = np.eye(4)
    if isinstance(solid, ur10e.Cylinder) and solid.axis == "x":
        T[:3, :3] = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]
    if isinstance(solid, ur10e.Cylinder) and solid.axis == "y":
        T[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    return T


def _geometry(solid: ur10e.Solid) -> str:
    if isinstance(solid, ur10e.Box):
        return f'<box size="{_numbers(np.asarray(solid.size_m))}"/>'
    return f'<cylinder radius="{solid.radius_m:.17g}" length="{solid.length_m:.17g}"/>'


def _revolute(i: int, child: str) -> str:
    limit = (
        f'<limit lower="{-ur10e.Q_MAX_RAD[i]:.17g}" upper="{ur10e.Q_MAX_RAD[i]:.17g}" '
        f'effort="{ur10e.TORQUE_MAX_NM[i]:.17g}" velocity="{ur10e.QD_MAX_RAD_S[i]:.17g}"/>'
    )
    ends = f'<parent link="{ur10e.LINKS[i]}"/><child link="{child}"/>'
    where = _origin(ur10e.JOINT_ORIGINS[i])
    return (
        f'  <joint name="{ur10e.JOINTS[i]}" type="revolute">'
        f'{ends}{where}<axis xyz="0 0 1"/>{limit}</joint>'
    )


def _prismatic(
    name: str, parent: str, child: str, axis: str, range_m: tuple[float, float], effort_n: float
) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    limit = (
        f'<limit lower="{range_m[0]}" upper="{range_m[1]}" effort="{effort_n}" velocity="0.16"/>'
    )
    return f'  <joint name="{name}" type="prismatic">{ends}<axis xyz="{axis}"/>{limit}</joint>'


def _fixed(child: str, parent: str, T_parent_child: Array) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    where = _origin(T_parent_child)
    return f'  <joint name="{child}_mount" type="fixed">{ends}{where}</joint>'


def _origin(T: Array) -> str:
    """The origin tag of a (4, 4) transform: translation and fixed-axis roll, pitch, yaw."""
    R = T[:3, :3]
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    if np.hypot(R[0, 0], R[1, 0]) > 1e-9:
        roll, yaw = np.arctan2(R[2, 1], R[2, 2]), np.arctan2(R[1, 0], R[0, 0])
    else:  # gimbal lock: only the sum of roll and yaw is defined
        roll, yaw = np.arctan2(-R[1, 2], R[1, 1]), 0.0
    angles = _numbers(np.array([roll, pitch, yaw]))
    return f'<origin xyz="{_numbers(T[:3, 3])}" rpy="{angles}"/>'


def _numbers(values: Array) -> str:
    return " ".join(f"{float(v) + 0.0:.17g}" for v in values)


def _triple(values: Array) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z
