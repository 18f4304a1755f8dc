"""From a row of the cell file to where the flange must be, and back."""

import numpy as np

from surefetch.common.cell import Cell, View
from surefetch.common.geometry import Array, inverse, rotation_angle
from surefetch.common.viewpoint import camera_pose
from surefetch.executor.robot import ur10e

AT_VIEW_M = 0.02
AT_VIEW_RAD = float(np.radians(2.0))


def flange_pose(cell: Cell, view: View) -> Array:
    """T_world_flange (4, 4) that puts the camera at its view."""
    pose: Array = camera_pose(cell, view) @ inverse(ur10e.camera_mount(cell.camera))
    return pose


def view_at(cell: Cell, q_rad: Array) -> str | None:
    """The view at which the camera is with these joints (6,), or None between views."""
    T_world_camera = ur10e.flange(q_rad) @ ur10e.camera_mount(cell.camera)
    for view in cell.views:
        off = inverse(camera_pose(cell, view)) @ T_world_camera
        if np.linalg.norm(off[:3, 3]) < AT_VIEW_M and rotation_angle(off[:3, :3]) < AT_VIEW_RAD:
            return view.name
    return None
