"""A scene on the simulated table, with an executor and a perception at one desk beside it."""

from types import TracebackType
from typing import Final, Self

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.errors import InfrastructureError
from surefetch.common.geometry import rigid, rotation_z
from surefetch.common.messages import AskTruth, Observations, Scene
from surefetch.evaluation.recordings import labels
from surefetch.evaluation.recordings.desk import Desk
from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.service import ExecutorService
from surefetch.executor.simulation import scene_bodies
from surefetch.executor.simulation.pybullet_cell import PybulletCell
from surefetch.executor.simulation.pybullet_devices import pybullet_devices
from surefetch.executor.simulation.pybullet_world import STEP_S
from surefetch.executor.simulation.scorer_questions import Simulation
from surefetch.executor.skills.situation import Workcell
from surefetch.perception.backends import BACKENDS
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.service import PerceptionService

LID_RESTS_S: Final = 0.25


class Bench:
    """The services' own code, as their processes wire it."""

    def __init__(self, scene: Scene, cell: Cell, backend: str, desk: Desk) -> None:
        self.cell = cell
        self.simulated = PybulletCell(cell)
        self.devices = pybullet_devices(self.simulated)
        self.executor = ExecutorService(
            Workcell.of(cell, AntipodalProposer()),
            self.devices,
            desk,
            backend="pybullet",
            simulated=Simulation(self.simulated),
        )
        geometry = LatestGeometry()
        self.perception = PerceptionService(desk, BACKENDS[backend](geometry), geometry)
        desk.seat(self.executor.handles)
        desk.seat(self.perception.handles)
        self._names = [body.name for body in scene.bodies]
        self.executor.load_scene(scene)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.simulated.close()

    def lift_lid(self) -> None:
        """Put the lid where the arm puts it, at rest."""
        place = self.cell.lid_place
        low = np.array([0.0, 0.0, scene_bodies.LID_THICKNESS_M / 2.0])
        turned = rotation_z(float(np.radians(place.yaw_deg)))
        world = self.simulated.world
        world.put(scene_bodies.LID, rigid(turned, np.asarray(place.position_m) + low))
        world.step(round(LID_RESTS_S / STEP_S))

    def bodies_under(self, seen: Observations) -> dict[str, str | None]:
        """The body under each detection of a frame that was just taken. For the scorer alone."""
        segmentation = self.executor.truth(AskTruth(frame=seen.frame)).segmentation
        if segmentation is None:
            raise InfrastructureError(f"the simulated cell has no segmentation of {seen.frame}")
        return labels.bodies_under(seen, segmentation, self._names)
