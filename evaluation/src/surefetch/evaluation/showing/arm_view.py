"""The arm in Rerun: its envelopes on the links, moved by the joints.

The robot's tables belong to the executor's distribution. Without it, the joint angles are plotted
in place of the arm.
"""

from typing import Any, Final

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.common.messages import Motion

try:
    from surefetch.executor.robot import ur10e, urdf
except ImportError:
    _HAS_ROBOT = False
else:
    _HAS_ROBOT = True

ARM: Final = "world/arm"
SAMPLES_PER_S: Final = 15.0
ARM_COLOR: Final = (176, 184, 196)
HAND_COLOR: Final = (70, 76, 84)


def log_envelopes(recording: rr.RecordingStream) -> None:
    """The shapes of the links, once and for all times."""
    if not _HAS_ROBOT:
        return
    for solid in (*ur10e.ARM_SHAPES, *ur10e.GRIPPER_SHAPES):
        path = f"{ARM}/{solid.link}/{solid.name.replace(' ', '_')}"
        color = HAND_COLOR if solid in ur10e.GRIPPER_SHAPES else ARM_COLOR
        recording.log(path, _shape(solid, color), static=True)


def _shape(solid: Any, color: tuple[int, int, int]) -> Any:
    if isinstance(solid, ur10e.Box):
        return rr.Boxes3D(
            centers=[solid.center_m], sizes=[solid.size_m], colors=[color], fill_mode="solid"
        )
    return rr.Cylinders3D(
        centers=[solid.center_m],
        quaternions=[_quaternion(urdf.solid_rotation(solid)[:3, :3])],
        lengths=[solid.length_m],
        radii=[solid.radius_m],
        colors=[color],
        fill_mode="solid",
    )


def log_joints(recording: rr.RecordingStream, q_rad: Array, gripper_width_m: float) -> None:
    """The arm at joints (6,) with its fingers this far open, at the recording's present time."""
    if not _HAS_ROBOT:
        recording.log("joints", rr.Scalars(q_rad))
        return
    for name, T in zip(ur10e.LINKS, ur10e.link_frames(q_rad), strict=True):
        recording.log(f"{ARM}/{name}", rr.Transform3D(translation=T[:3, 3], mat3x3=T[:3, :3]))
    recording.log(
        f"{ARM}/tool0/fingers",
        rr.Boxes3D(
            centers=np.stack(ur10e.finger_centers(gripper_width_m)),
            sizes=[ur10e.FINGER_SIZE_M] * 2,
            colors=[HAND_COLOR] * 2,
            fill_mode="solid",
        ),
    )


def samples(motion: Motion) -> NDArray[np.intp]:
    """Indices (n,) of the samples to show: thinned, with the first and the last."""
    times_s = motion.times_s
    if len(times_s) == 0:
        return np.zeros(0, np.intp)
    n = max(2, round(float(times_s[-1]) * SAMPLES_PER_S))
    picked = np.unique(np.searchsorted(times_s, np.linspace(times_s[0], times_s[-1], n)))
    return np.minimum(picked, len(times_s) - 1)


def _quaternion(R: Array) -> Array:
    """(x, y, z, w) of the few rotations in the table: about one axis, by at most a right angle."""
    w = np.sqrt(max(0.0, 1.0 + np.trace(R))) / 2.0
    xyz = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / (4.0 * w)
    return np.append(xyz, w)
