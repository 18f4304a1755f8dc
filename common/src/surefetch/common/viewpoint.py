"""From a row of the cell file to where the camera stands."""

from typing import Final

import numpy as np

from surefetch.common.cell import Cell, View
from surefetch.common.geometry import Array, look_at

_UP: Final = np.array([0.0, 0.0, 1.0])


def camera_pose(cell: Cell, view: View) -> Array:
    """T_world_camera (4, 4): on the sphere about the look-at point, image-up towards world z.

    Azimuth 0 is the robot's side of the look-at point, positive towards -y.
    """
    elevation, azimuth = np.radians(view.elevation_deg), np.radians(view.azimuth_deg)
    level = np.cos(elevation)
    towards = np.array([-level * np.cos(azimuth), -level * np.sin(azimuth), np.sin(elevation)])
    center = np.asarray(cell.look_at_m)
    return look_at(center + view.distance_m * towards, center, _UP)
