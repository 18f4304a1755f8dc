"""Pictures of simulated tables for tests of perception, with the truth about every pixel."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import simulated_cell
from surefetch.common.geometry import Array, intrinsics
from surefetch.common.messages import Scene, Target
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.common.viewpoint import camera_pose
from surefetch.executor.simulation.pybullet_world import PybulletWorld
from surefetch.executor.simulation.sensor_noise import noisy_depth, noisy_rgb
from surefetch.perception.classical import classical_backend
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.observe import Perceived, observe

ANYTHING = Target(noun="object")


@dataclass(frozen=True, eq=False)
class Shot:
    """A frame as a sensor gives it, and which body each pixel shows."""

    frame: RgbdFrame
    segmentation: NDArray[np.int16]
    """(h, w), numbered as in `messages.Truth`"""

    def pixels_of(self, body: int) -> NDArray[np.bool_]:
        """The visible pixels (h, w) of one body, or of what a negative number stands for."""
        return np.asarray(self.segmentation == body)


def view_pose(view: str) -> Array:
    """T_world_camera of a view of the simulated cell."""
    cell = simulated_cell()
    return camera_pose(cell, next(row for row in cell.views if row.name == view))


def shoot(
    scene: Scene,
    view: str | Array = "center",
    *,
    size: tuple[int, int] = (640, 480),
    fov_deg: float = 50.0,
    pose_known: bool = True,
    seed: int = 0,
) -> Shot:
    """Settle the scene and take a noisy picture of it from a named view or a pose."""
    width, height = size
    K = intrinsics(width, height, fov_deg)
    T = view_pose(view) if isinstance(view, str) else view
    with PybulletWorld(scene) as world:
        world.settle(0.5)
        picture = world.render(T, K, width, height)
    rng = np.random.default_rng(seed)
    frame = RgbdFrame(
        rgb=noisy_rgb(picture.rgb, rng),
        depth_m=noisy_depth(picture.depth_m, picture.rgb, rng),
        K=K,
        T_world_camera=T if pose_known else None,
        view=view if isinstance(view, str) else None,
    )
    return Shot(frame, picture.segmentation)


def perceive(frame: RgbdFrame, target: Target = ANYTHING) -> Perceived:
    """What the classical back-end sees in a frame."""
    geometry = LatestGeometry()
    return observe(frame, target, classical_backend(geometry), geometry)
