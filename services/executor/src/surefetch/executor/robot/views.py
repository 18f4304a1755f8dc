"""From a row of the cell file to where the camera and the flange must be."""

import numpy as np

from surefetch.common.cell import Cell, View
from surefetch.common.geometry import Array, inverse, look_at, rotation_angle
from surefetch.executor.robot import ur10e

UP = np.array([0.0, 0.0, 1.0])
AT_VIEW_M = 0.02
AT_VIEW_RAD = float(np.radians(2.0))


def camera_pose(cell: Cell, view: View) -> Array:
    """T_world_camera (4, 4): on the sphere about the look-at point, image-up towards world z.

    Azimuth 0 is the robot's side of the look-at point, positive towards -y.
    """
    elevation, azimuth = np.radians(view.elevation_deg), np.radians(view.azimuth_deg)
    level = np.cos(elevation)
    towards = np.array([-level * np.cos(azimuth), -level * np.sin(azimuth), np.sin(elevation)])
    center = np.asarray(cell.look_at_m)
    return look_at(center + view.distance_m * towards, center, UP)


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
