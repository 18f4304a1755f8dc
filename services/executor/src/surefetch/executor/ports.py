"""The devices of a cell: arm, gripper, camera. Simulation and hardware stand behind one port."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.common.messages import AskTruth, Scene, SceneLoaded, Truth

StopRequested = Callable[[], bool]
"""Polled during motion; true means: come to rest now."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Joints over time, from rest to rest, already checked."""

    times_s: Array
    """(n,), strictly increasing from 0"""
    q_rad: Array
    """(n, 6)"""


@dataclass(frozen=True, eq=False)
class Image:
    """What a camera gives: registered colour and depth, and its intrinsics."""

    rgb: NDArray[np.uint8]
    """(h, w, 3)"""
    depth_m: NDArray[np.float32]
    """(h, w), along the optical axis; 0 where missing"""
    K: Array
    """(3, 3), pixels"""


class Arm(Protocol):
    """A six-joint arm."""

    def joints_rad(self) -> Array:
        """(6,) measured."""
        ...

    def follow(self, trajectory: Trajectory, stop: StopRequested) -> bool:
        """Drive the trajectory, which must start where the arm is; True when its end was reached.

        Raises:
            DeviceFault: the arm is not at the start, or left the path; it has come to rest.
        """
        ...


class Gripper(Protocol):
    """A two-finger hand. Widths are between the finger pads, in metres."""

    def width_m(self) -> float:
        """Measured."""
        ...

    def move(self, width_m: float, force_n: float, stop: StopRequested) -> float:
        """Open or close towards the width until there or stopped by contact; the width reached."""
        ...

    def grip_detected(self) -> bool:
        """Whether the fingers press on something, as the device itself can tell."""
        ...


class Camera(Protocol):
    """A registered RGB-D camera."""

    def capture(self) -> Image:
        """A fresh image; the arm stands still."""
        ...


@dataclass(frozen=True)
class Devices:
    """The three devices of one cell."""

    arm: Arm
    gripper: Gripper
    camera: Camera


class SimulatedCell(Protocol):
    """What only a simulated cell can do, for the scorer: no planning ever sees it."""

    def load_scene(self, scene: Scene) -> SceneLoaded:
        """Replace what is on the table; the arm starts at home."""
        ...

    def truth(self, ask: AskTruth) -> Truth:
        """Where everything is."""
        ...
