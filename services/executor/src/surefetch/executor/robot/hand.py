"""The gripper's geometry as a value: what a grasp proposer must know of the hand."""

from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array
from surefetch.executor.robot import ur10e

CLEARANCE_M = 0.010


@dataclass(frozen=True, eq=False)
class Palm:
    """A box of the hand above the fingers, in the flange frame (z out of the flange).

    A vertical approach needs the column over its footprint free down to its lowest face.
    """

    center_xy_m: Array
    """(2,)"""
    half_xy_m: Array
    """(2,)"""
    face_z_m: float
    """Flange to its face towards the fingertips"""


@dataclass(frozen=True, eq=False)
class Hand:
    """A parallel gripper that closes along its y; fingers are boxes along z."""

    width_max_m: float
    """Largest opening between the pads"""
    finger_breadth_m: float
    """Across the closing direction"""
    finger_thickness_m: float
    """Along the closing direction"""
    clearance_m: float
    """Wanted on each side between pad and object while approaching"""
    palms: tuple[Palm, ...]

    def tip_z_m(self, width_m: float | Array) -> Array:
        """Flange to the fingertips' ends at an opening; the tips draw back as the hand opens."""
        reach: Array = np.asarray(ur10e.TIP_Z_M - ur10e.retraction_m(width_m))
        return reach

    @property
    def object_width_max_m(self) -> float:
        """The widest object that still leaves the clearance on both sides."""
        return self.width_max_m - 2.0 * self.clearance_m


def rg6(T_flange_camera: Array) -> Hand:
    """The RG6 with the camera beside it, from the robot's tables."""
    body = next(s for s in ur10e.GRIPPER_SHAPES if isinstance(s, ur10e.Box))
    return Hand(
        width_max_m=ur10e.WIDTH_MAX_M,
        finger_breadth_m=ur10e.FINGER_BREADTH_M,
        finger_thickness_m=ur10e.FINGER_THICKNESS_M,
        clearance_m=CLEARANCE_M,
        palms=(
            _palm(np.asarray(body.center_m), np.asarray(body.size_m), np.eye(3)),
            _camera(T_flange_camera),
        ),
    )


def _palm(center_m: Array, size_m: Array, R_flange_box: Array) -> Palm:
    """The box around a box turned in the flange frame."""
    half = np.abs(R_flange_box) @ (size_m / 2.0)
    return Palm(center_m[:2], half[:2], float(center_m[2] + half[2]))


def _camera(T_flange_camera: Array) -> Palm:
    body = ur10e.CAMERA_BODY
    center = T_flange_camera[:3, :3] @ np.asarray(body.center_m) + T_flange_camera[:3, 3]
    return _palm(center, np.asarray(body.size_m), T_flange_camera[:3, :3])
