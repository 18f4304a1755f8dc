"""Captures and perceives every state of a scene once, with the services' own code in one process.

The arm is driven to each view along a straight joint move, so that it ends there as it always
does: off by the view's arrival error, which the joints measure. The lid is put down where the arm
would put it. Noise and pose errors are those of the first capture in that state, so a frame is the
one that a live run would get, but for the last micrometres in which the arm comes to rest.
"""

import time
from types import TracebackType
from typing import Final, Self

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.errors import InfrastructureError
from surefetch.common.geometry import Array, rigid, rotation_z
from surefetch.common.messages import (
    AskFeasible,
    AskTruth,
    Capture,
    Feasibility,
    Frame,
    FrameId,
    Observations,
    Observe,
    Truth,
)
from surefetch.common.topics import FRAME
from surefetch.evaluation.recordings import labels as recording_labels
from surefetch.evaluation.recordings.desk import Desk
from surefetch.evaluation.recordings.free_space import FreeSpace, seen_in
from surefetch.evaluation.recordings.made_with import made_with
from surefetch.evaluation.recordings.recording import (
    FORMAT,
    Recording,
    RecordingTruth,
    Shot,
    ShotTruth,
    State,
    states,
)
from surefetch.evaluation.scenes import rejection
from surefetch.evaluation.scenes.body_matches import body_matches
from surefetch.evaluation.scenes.generate import GeneratedScene
from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.ports import Trajectory
from surefetch.executor.robot import kinematics, views
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

MOVE_S: Final = 2.5
SAMPLES: Final = 60
LID_RESTS_S: Final = 0.25
MOVED_M: Final = 0.002
"""A body that has moved farther than this was touched by the arm."""
WHO: Final = "recording"


class Studio:
    """One scene on the simulated table, an executor and a perception beside it."""

    def __init__(self, generated: GeneratedScene, cell: Cell, backend: str) -> None:
        self._generated = generated
        self._cell = cell
        self._desk = desk = Desk(f"{generated.scene.family}-{generated.scene.seed}")
        self._simulated = PybulletCell(cell)
        self._devices = pybullet_devices(self._simulated)
        self._executor = ExecutorService(
            Workcell.of(cell, AntipodalProposer()),
            self._devices,
            desk,
            backend="pybullet",
            simulated=Simulation(self._simulated),
        )
        desk.seat(self._executor.handles)
        geometry = LatestGeometry()
        self._perception = PerceptionService(desk, BACKENDS[backend](geometry), geometry)
        self._executor.load_scene(generated.scene)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._simulated.close()

    def record(self) -> tuple[Recording, RecordingTruth]:
        """Every state that can be reached, once.

        Raises:
            InfrastructureError: the arm touched something on its way.
        """
        started, before = time.perf_counter(), self._truth()
        spent_s = {"captures": 0.0, "perception": 0.0}
        covered = self._simulated.covered()
        shots: list[Shot] = []
        truths: list[ShotTruth] = []
        for state in states(covered, self._cell):
            if state.cover == "open" and self._simulated.covered():
                self.lift_lid()
            shots.append(self._shot(state, spent_s))
            truths.append(self._labelled(state, shots[-1].observations))
        self._check_nothing_moved(before)
        spent_s["all"] = time.perf_counter() - started
        return self._recording(covered, shots, spent_s), self._recording_truth(truths)

    def look(self, view: str) -> Observations:
        """Drive to a view, capture and perceive."""
        return self.perceive(self.capture(view))

    def _shot(self, state: State, spent_s: dict[str, float]) -> Shot:
        """One state; what it took is added to `spent_s`."""
        began = time.perf_counter()
        frame = self.frame(self.capture(state.view))
        captured = time.perf_counter()
        seen = self.perceive(frame.info.frame)
        spent_s["captures"] += captured - began
        spent_s["perception"] += time.perf_counter() - captured
        return Shot(
            state=state,
            observations=seen,
            K=frame.info.K,
            T_world_camera=frame.info.T_world_camera,
            q_rad=frame.q_rad,
            free_space=FreeSpace.of(seen_in(frame)),
        )

    def capture(self, view: str) -> FrameId:
        """Drive to a view and take a frame."""
        self._drive(view)
        return self._executor.capture(Capture(episode=WHO, step=0)).frame

    def frame(self, frame: FrameId) -> Frame:
        """The pixels of a frame that was taken."""
        return self._desk.ask(FRAME, frame, timeout_s=1.0)

    def perceive(self, frame: FrameId) -> Observations:
        """What perception says of a frame."""
        asked = Observe(episode=WHO, step=0, frame=frame, target=self._generated.target)
        return self._perception.observe(asked)

    def feasible(self, ask: AskFeasible) -> Feasibility:
        """What the executor could do now."""
        return self._executor.feasible(ask)

    def lift_lid(self) -> None:
        """Put the lid where the arm puts it, at rest."""
        place = self._cell.lid_place
        low = np.array([0.0, 0.0, scene_bodies.LID_THICKNESS_M / 2.0])
        turned = rotation_z(float(np.radians(place.yaw_deg)))
        world = self._simulated.world
        world.put(scene_bodies.LID, rigid(turned, np.asarray(place.position_m) + low))
        world.step(round(LID_RESTS_S / STEP_S))

    def _drive(self, view: str) -> None:
        start = self._devices.arm.joints_rad()
        pose = views.flange_pose(self._cell, self._cell.view(view))
        end = kinematics.solutions(pose, start)[0]
        self._devices.arm.follow(_straight(start, end), lambda: False)

    def _truth(self, frame: FrameId | None = None) -> Truth:
        return self._executor.truth(AskTruth(frame=frame))

    def _labelled(self, state: State, seen: Observations) -> ShotTruth:
        segmentation = self._truth(seen.frame).segmentation
        if segmentation is None:
            raise InfrastructureError(f"the simulated cell has no segmentation of {seen.frame}")
        names = [body.name for body in self._generated.scene.bodies]
        return ShotTruth(
            state=state, bodies=recording_labels.bodies_under(seen, segmentation, names)
        )

    def _check_nothing_moved(self, before: Truth) -> None:
        for then, now in zip(before.bodies, self._truth().bodies, strict=True):
            moved = np.subtract(now.position_world_m, then.position_world_m)
            if np.linalg.norm(moved) > MOVED_M:
                scene = self._generated.scene
                raise InfrastructureError(
                    f'recording {scene.family}:{scene.seed}, "{now.name}" was moved by '
                    f"{1e3 * np.linalg.norm(moved):.1f} mm: the arm touched it between two views."
                )

    def _recording(self, covered: bool, shots: list[Shot], spent_s: dict[str, float]) -> Recording:
        scene = self._generated.scene
        return Recording(
            format=FORMAT,
            family=scene.family,
            seed=scene.seed,
            made_with=made_with(self._cell, self._perception.backend),
            sentence=self._generated.sentence,
            target=self._generated.target,
            covered=covered,
            shots=tuple(shots),
            feasible=(),
            differing=None,
            perception_s=(),
            durations_s=spent_s,
        )

    def _recording_truth(self, truths: list[ShotTruth]) -> RecordingTruth:
        scene, truth = self._generated.scene, self._generated.truth
        return RecordingTruth(
            format=FORMAT,
            family=scene.family,
            seed=scene.seed,
            target=truth.target,
            relation=truth.relation,
            graspable=tuple(b.name for b in scene.bodies if not rejection.too_wide(b)),
            matches=body_matches(scene, self._generated.target),
            shots=tuple(truths),
        )


def _straight(start_rad: Array, end_rad: Array) -> Trajectory:
    """Straight in joint space from rest to rest, by the quintic law."""
    times_s = np.linspace(0.0, MOVE_S, SAMPLES)
    share = (times_s / MOVE_S)[:, None]
    smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return Trajectory(times_s=times_s, q_rad=start_rad + smooth * (end_rad - start_rad))
