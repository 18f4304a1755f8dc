"""From the camera: frames and what is asked for to get them."""

import numpy as np
from numpy.typing import NDArray

from surefetch.common import arrays
from surefetch.common.messages.base import Message, Name


class FrameId(Message, frozen=True):
    """One image of one executor process."""

    boot: Name
    counter: int


class Capture(Message, frozen=True):
    """Ask the executor for a fresh image from where the arm stands."""

    episode: Name
    step: int


class FrameInfo(Message, frozen=True, eq=False):
    """What the planner needs of a frame; the bytes go from executor to perception."""

    frame: FrameId
    view: str | None
    """Row of the cell file at which the arm stands; None between views."""
    width: int
    height: int
    K: NDArray[np.float64]
    """(3, 3) intrinsics, pixels."""
    T_world_camera: NDArray[np.float64]
    """(4, 4) from the measured joints and the hand-eye transform."""
    captured_s: float
    """The executor's monotonic clock."""

    def __post_init__(self) -> None:
        arrays.check("K", self.K, np.float64, (3, 3))
        arrays.check("T_world_camera", self.T_world_camera, np.float64, (4, 4))


class Frame(Message, frozen=True, eq=False):
    """One colour-and-depth image, registered, and where the camera was when it was taken."""

    info: FrameInfo
    rgb: NDArray[np.uint8]
    """(h, w, 3)"""
    depth_m: NDArray[np.float32]
    """(h, w), along the optical axis; 0 where missing."""
    q_rad: tuple[float, ...]
    """Measured joints."""
    gripper_width_m: float

    def __post_init__(self) -> None:
        h, w = self.info.height, self.info.width
        arrays.check("rgb", self.rgb, np.uint8, (h, w, 3))
        arrays.check("depth_m", self.depth_m, np.float32, (h, w))
