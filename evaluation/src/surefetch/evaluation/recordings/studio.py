"""Captures and perceives every state of a scene once, with the services' own code in one process.

The arm is driven to each view along a straight joint move, so that it ends there as it always
does: off by the view's arrival error, which the joints measure. The lid is put down where the arm
would put it, once, after all that can be seen while it is on. Noise and pose errors are those of
the first capture in that state, so a frame is the one that a live run would get, but for the last
micrometres in which the arm comes to rest.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.errors import InfrastructureError
from surefetch.common.geometry import Array
from surefetch.common.messages import (
    AskTruth,
    Capture,
    Frame,
    FrameId,
    Observations,
    Observe,
    Truth,
)
from surefetch.common.topics import FRAME
from surefetch.evaluation.recordings.bench import Bench
from surefetch.evaluation.recordings.desk import Desk
from surefetch.evaluation.recordings.free_space import FreeSpace, seen_in
from surefetch.evaluation.recordings.made_with import made_with
from surefetch.evaluation.recordings.pictures import Picture, Pictures
from surefetch.evaluation.recordings.prospects import prospects
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
from surefetch.executor.ports import Trajectory
from surefetch.executor.robot import kinematics, views

MOVE_S: Final = 1.0
SAMPLES: Final = 60
MOVED_M: Final = 0.002
"""A body that has moved farther than this was touched by the arm."""
WHO: Final = "recording"


@dataclass(frozen=True, eq=False)
class Recorded:
    """All that is kept of one scene."""

    recording: Recording
    truth: RecordingTruth
    pictures: Pictures


class Studio(Bench):
    """Where one scene is recorded."""

    def __init__(self, generated: GeneratedScene, cell: Cell, backend: str) -> None:
        self._generated = generated
        self._desk = Desk(f"{generated.scene.family}-{generated.scene.seed}")
        super().__init__(generated.scene, cell, backend, self._desk)
        self._spent_s: dict[str, float] = {}

    def record(self) -> Recorded:
        """Every state that can be reached, once, and what the robot could do after each history.

        Raises:
            InfrastructureError: the arm touched something on its way.
        """
        covered, before = self.simulated.covered(), self._truth()
        seen = [self._state(state) for state in states(covered, self.cell)]
        self._check_nothing_moved(before)
        shots = tuple(shot for shot, _, _ in seen)
        return Recorded(
            recording=self._recording(covered, shots),
            truth=self._recording_truth(tuple(truth for _, truth, _ in seen)),
            pictures=self._pictures(tuple(picture for _, _, picture in seen)),
        )

    def shots(self) -> tuple[Shot, ...]:
        """Every state that can be reached, and nothing else of the scene."""
        reached = states(self.simulated.covered(), self.cell)
        return tuple(self._state(state)[0] for state in reached)

    def _state(self, state: State) -> tuple[Shot, ShotTruth, Picture]:
        """One state, captured and perceived."""
        if state.cover == "open" and self.simulated.covered():
            self.lift_lid()
        with self._timed("captures"):
            frame = self.frame(self.capture(state.view))
        with self._timed("perception"):
            seen = self.perceive(frame.info.frame)
        with self._timed("free space, pictures"):
            shot = Shot(
                state=state,
                observations=seen,
                K=frame.info.K,
                T_world_camera=frame.info.T_world_camera,
                q_rad=frame.q_rad,
                free_space=FreeSpace.of(seen_in(frame)),
            )
            picture = Picture.of(state, np.asarray(frame.rgb))
        return shot, ShotTruth(state=state, bodies=self.bodies_under(seen)), picture

    @contextmanager
    def _timed(self, what: str) -> Iterator[None]:
        """Add the processor time of what is done meanwhile."""
        began_s = time.process_time()
        yield
        self._spent_s[what] = self._spent_s.get(what, 0.0) + time.process_time() - began_s

    def capture(self, view: str) -> FrameId:
        """Drive to a view and take a frame."""
        self._drive(view)
        return self.executor.capture(Capture(episode=WHO, step=0)).frame

    def frame(self, frame: FrameId) -> Frame:
        """The pixels of a frame that was taken."""
        return self._desk.ask(FRAME, frame, timeout_s=1.0)

    def perceive(self, frame: FrameId) -> Observations:
        """What perception says of a frame."""
        asked = Observe(episode=WHO, step=0, frame=frame, target=self._generated.target)
        return self.perception.observe(asked)

    def _drive(self, view: str) -> None:
        start = self.devices.arm.joints_rad()
        pose = views.flange_pose(self.cell, self.cell.view(view))
        end = kinematics.solutions(pose, start)[0]
        self.devices.arm.follow(_straight(start, end), lambda: False)

    def _truth(self) -> Truth:
        return self.executor.truth(AskTruth())

    def _check_nothing_moved(self, before: Truth) -> None:
        for then, now in zip(before.bodies, self._truth().bodies, strict=True):
            moved = np.subtract(now.position_world_m, then.position_world_m)
            if np.linalg.norm(moved) > MOVED_M:
                scene = self._generated.scene
                raise InfrastructureError(
                    f'recording {scene.family}:{scene.seed}, "{now.name}" was moved by '
                    f"{1e3 * np.linalg.norm(moved):.1f} mm: the arm touched it between two views."
                )

    def _recording(self, covered: bool, shots: tuple[Shot, ...]) -> Recording:
        scene = self._generated.scene
        with self._timed("feasibility"):
            feasible = prospects(shots, covered, self.cell, (scene.family, scene.seed))
        return Recording(
            format=FORMAT,
            family=scene.family,
            seed=scene.seed,
            made_with=made_with(self.cell, self.perception.backend),
            sentence=self._generated.sentence,
            target=self._generated.target,
            covered=covered,
            shots=shots,
            feasible=feasible,
            repeated=None,
            durations_s=self._spent_s,
        )

    def _pictures(self, pictures: tuple[Picture, ...]) -> Pictures:
        scene = self._generated.scene
        return Pictures(format=FORMAT, family=scene.family, seed=scene.seed, pictures=pictures)

    def _recording_truth(self, truths: tuple[ShotTruth, ...]) -> RecordingTruth:
        scene, truth = self._generated.scene, self._generated.truth
        return RecordingTruth(
            format=FORMAT,
            family=scene.family,
            seed=scene.seed,
            target=truth.target,
            relation=truth.relation,
            graspable=tuple(b.name for b in scene.bodies if not rejection.too_wide(b)),
            matches=body_matches(scene, self._generated.target),
            shots=truths,
        )


def _straight(start_rad: Array, end_rad: Array) -> Trajectory:
    """Straight in joint space from rest to rest, by the quintic law."""
    times_s = np.linspace(0.0, MOVE_S, SAMPLES)
    share = (times_s / MOVE_S)[:, None]
    smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return Trajectory(times_s=times_s, q_rad=start_rad + smooth * (end_rad - start_rad))
