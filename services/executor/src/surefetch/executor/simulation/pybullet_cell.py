"""The simulated cell as a whole: one scene, the robot in it, and what belongs to its seed."""

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import Cell
from surefetch.common.geometry import Array, inverse
from surefetch.common.messages import Lighting, Scene
from surefetch.common.settings import GripModel
from surefetch.common.streams import stream
from surefetch.common.viewpoint import camera_pose
from surefetch.executor.robot import ur10e, views
from surefetch.executor.simulation import pose_errors, scene_bodies
from surefetch.executor.simulation.pybullet_robot import SimulatedRobot
from surefetch.executor.simulation.pybullet_world import PybulletWorld

SEGMENTATIONS = 64
EMPTY_TABLE = Scene(
    family="empty",
    seed=0,
    generator_version=0,
    bodies=(),
    container=None,
    screens=(),
    lighting=Lighting(direction=(-0.4, 0.5, 1.0), ambient=0.45, diffuse=0.6, specular=0.05),
    table_rgb=(0.72, 0.66, 0.58),
)


class PybulletCell:
    """Holds the scene that is loaded now; the devices ask it at every use."""

    def __init__(self, cell: Cell, grip_model: GripModel = "contact_then_hold") -> None:
        self.cell = cell
        self._grip_model = grip_model
        self._mount = ur10e.camera_mount(cell.camera)
        self.images = 0
        self._segmentations: dict[int, NDArray[np.int16]] = {}
        self.world = PybulletWorld(EMPTY_TABLE)
        self.load(EMPTY_TABLE)

    def load(self, scene: Scene) -> float:
        """Put this scene on the table, let it settle, the arm at home; the largest shift in m."""
        self.world.close()
        self.world = PybulletWorld(scene)
        shift_m = self.world.settle()
        home = np.radians(self.cell.home.q_deg)
        self.robot = SimulatedRobot(self.world, self._mount, home, self._grip_model)
        self._error = pose_errors.hand_eye_error(scene.family, scene.seed)
        self._images: Counter[tuple[str, str]] = Counter()
        self.touched: list[str] = []
        return shift_m

    def close(self) -> None:
        """End the simulation."""
        self.world.close()

    def covered(self) -> bool:
        """Whether the lid lies on the container now."""
        container = self.world.scene.container
        if container is None or not container.covered:
            return False
        lid, box = self.world.pose(scene_bodies.LID), self.world.pose(scene_bodies.CONTAINER)
        x, y, z = (inverse(box) @ lid)[:3, 3]
        across, along = container.inner_size_m
        return bool(
            abs(x) < across / 2.0 and abs(y) < along / 2.0 and z < container.wall_height_m + 0.03
        )

    def closed(self) -> None:
        """The fingers have closed: hold what is between them, and remember which body it was."""
        index = self.robot.hand.hold(self.robot.tips_world_m())
        if index is not None and self.world.things[index].segment >= 0:
            name = self.world.things[index].name
            if name not in self.touched:
                self.touched.append(name)

    def held(self) -> str | None:
        """What the hand holds."""
        index = self.robot.hand.held()
        return None if index is None else self.world.things[index].name

    def keep_segmentation(self, segmentation: NDArray[np.int16]) -> None:
        """Remember what the camera's next image shows; images are numbered from 1."""
        self.images += 1
        self._segmentations[self.images] = segmentation
        self._segmentations.pop(self.images - SEGMENTATIONS, None)

    def segmentation(self, image: int) -> NDArray[np.int16] | None:
        """What one of the latest images shows (h, w), numbered as in `messages.Truth`."""
        return self._segmentations.get(image)

    def next_image_stream(self) -> np.random.Generator:
        """Noise of the next image: by view, cover state, and how many there were of them."""
        view = views.view_at(self.cell, self.robot.joints_rad()) or "between views"
        key = (view, "covered" if self.covered() else "open")
        self._images[key] += 1
        scene = self.world.scene
        return stream(scene.family, scene.seed, "camera", "image", *key, self._images[key])

    def T_world_camera_true(self) -> Array:
        """(4, 4): where the camera is, its hidden error included."""
        pose: Array = self.robot.T_world_flange() @ self._mount @ self._error
        return pose

    def flange_on_arrival(self, view: str) -> Array:
        """T_world_flange (4, 4) at which the arm ends a move to this view, as things stand."""
        scene = self.world.scene
        error = pose_errors.arrival_error(scene.family, scene.seed, view, self.covered())
        T_world_camera = camera_pose(self.cell, self.cell.view(view)) @ error
        pose: Array = T_world_camera @ inverse(self._mount)
        return pose
