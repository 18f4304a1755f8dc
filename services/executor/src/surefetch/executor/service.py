"""The executor on the bus: frames, feasibility, commands, the stop.

Everything that touches arm, gripper, camera or simulation runs in the work loop, one after another.
Frames that were taken, and the stop, are answered at any time.
"""

import logging
import time
from typing import Any, Final

import numpy as np

from surefetch.common.bus import Bus
from surefetch.common.errors import Refused
from surefetch.common.messages import (
    AskFeasible,
    AskTruth,
    Capture,
    Command,
    Estimate,
    Feasibility,
    Frame,
    FrameId,
    FrameInfo,
    Outcome,
    Scene,
    SceneLoaded,
    Stop,
    Stopped,
    Truth,
)
from surefetch.common.runner import Handle
from surefetch.common.streams import stream
from surefetch.common.topics import (
    CAPTURE,
    EXECUTE,
    EXECUTOR,
    FEASIBLE,
    FRAME,
    LOAD_SCENE,
    MOVED,
    STOP,
    TRUTH,
)
from surefetch.executor.feasibility import judge
from surefetch.executor.frames import FrameRing
from surefetch.executor.outcomes import Outcomes
from surefetch.executor.ports import Devices, SimulatedCell
from surefetch.executor.robot import ur10e
from surefetch.executor.robot.views import view_at
from surefetch.executor.skills.commands import carry_out, check_names
from surefetch.executor.skills.execution import Execution
from surefetch.executor.skills.plans import Plans
from surefetch.executor.skills.situation import Memory, Situation, Workcell
from surefetch.executor.skills.task import Task
from surefetch.executor.stop_latch import StopLatch

log = logging.getLogger(__name__)


class ExecutorService:
    """Serves one cell. `simulated` adds the scorer's two topics."""

    name = EXECUTOR

    def __init__(
        self,
        workcell: Workcell,
        devices: Devices,
        bus: Bus,
        *,
        backend: str,
        simulated: SimulatedCell | None = None,
    ) -> None:
        self.backend: Final = backend
        self._workcell = workcell
        self._devices = devices
        self._bus = bus
        self._simulated = simulated
        self._plans = Plans(workcell)
        self._frames = FrameRing(bus.boot)
        self._n_frames = 0
        self._outcomes = Outcomes()
        self._latch = StopLatch()
        self._memory = Memory()
        self._doing = "idle"
        self._dice = (workcell.cell.name, 0)
        self._n_planned = 0

    @property
    def doing(self) -> str:
        """What moves now."""
        return f"stopped by {self._latch.who}" if self.stopped else self._doing

    @property
    def stopped(self) -> bool:
        """Whether a stop was asked for that forbids all motion."""
        return self._latch.asked()

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        """All topics; loading scenes and telling the truth only where the cell is simulated."""
        always: tuple[Handle[Any, Any], ...] = (
            Handle(CAPTURE, self.capture),
            Handle(FRAME, self._frames.get, concurrent=True),
            Handle(FEASIBLE, self.feasible),
            Handle(EXECUTE, self.execute),
            Handle(STOP, self.stop, concurrent=True),
        )
        if self._simulated is None:
            return always
        return (*always, Handle(LOAD_SCENE, self.load_scene), Handle(TRUTH, self.truth))

    def capture(self, _: Capture) -> FrameInfo:
        """Take an image from where the arm stands; its bytes are asked for by `frame`."""
        self._doing = "capturing"
        image = self._devices.camera.capture()
        q_rad = self._devices.arm.joints_rad()
        self._n_frames += 1
        height, width = image.depth_m.shape
        info = FrameInfo(
            frame=FrameId(boot=self._bus.boot, counter=self._n_frames),
            view=view_at(self._workcell.cell, q_rad),
            width=width,
            height=height,
            K=image.K,
            T_world_camera=ur10e.flange(q_rad) @ self._workcell.T_flange_camera,
            captured_s=time.monotonic(),
        )
        frame = Frame(
            info=info,
            rgb=image.rgb,
            depth_m=image.depth_m,
            q_rad=tuple(float(v) for v in q_rad),
            gripper_width_m=self._devices.gripper.width_m(),
        )
        self._frames.keep(frame)
        self._doing = "idle"
        return info

    def feasible(self, ask: AskFeasible) -> Feasibility:
        """What the robot could do now. Raises BadInput for an action that the cell lacks."""
        self._doing = "planning"
        verdict = judge(
            self._plans, self._workcell.cell, self._now(ask.estimate), ask, self._dice_cup()
        )
        self._doing = "idle"
        return verdict

    def execute(self, command: Command) -> Outcome:
        """Carry out a command once; a repeated one gets the stored outcome and moves nothing.

        Raises:
            Refused: ID_REUSED.
            BadInput: the command names what the cell lacks.
        """
        known = self._outcomes.of(command)
        if known is not None:
            return known
        check_names(self._workcell.cell, command.verb)
        outcome = self._carry_out(command)
        self._outcomes.keep(command, outcome)
        self._doing = "idle"
        log.info("%s: %s, %s", command.verb, outcome.status, outcome.why)
        return outcome

    def stop(self, request: Stop) -> Stopped:
        """End all motion; refuse all further, until a scene is loaded or the process restarts."""
        was_moving, took_s = self._latch.ask_and_wait(request.who)
        return Stopped(was_moving=was_moving, took_s=took_s)

    def end(self) -> None:
        """The process ends: bring the motion under way to a controlled stop."""
        self._latch.ask("the end of the process")

    def load_scene(self, scene: Scene) -> SceneLoaded:
        """Put a scene on the simulated table: the arm at home, nothing remembered, no stop."""
        assert self._simulated is not None
        self._doing = "loading a scene"
        loaded = self._simulated.load_scene(scene)
        self._memory = Memory()
        self._dice = (scene.family, scene.seed)
        self._n_planned = 0
        self._latch.release()
        self._doing = "idle"
        return loaded

    def truth(self, ask: AskTruth) -> Truth:
        """The scorer's question. Raises Refused (WRONG_BOOT) for another process's frame."""
        assert self._simulated is not None
        if ask.frame is not None and ask.frame.boot != self._bus.boot:
            raise Refused("WRONG_BOOT", f"frame {ask.frame.counter} is of another process")
        return self._simulated.truth(ask)

    def _carry_out(self, command: Command) -> Outcome:
        run = Execution(
            devices=self._devices,
            latch=self._latch,
            force_n=self._workcell.cell.speeds.grip_force_n,
            say=self._say,
            moved=lambda motion: self._bus.publish(MOVED, motion),
            memory=self._memory,
        )
        task = Task(run, self._workcell, self._plans, command.estimate, self._dice_cup())
        outcome = carry_out(task, command)
        self._memory = run.memory
        return outcome

    def _now(self, estimate: Estimate) -> Situation:
        q_rad, width_m = self._devices.arm.joints_rad(), self._devices.gripper.width_m()
        return Situation(q_rad, width_m, estimate, self._memory)

    def _dice_cup(self) -> np.random.Generator:
        """The path planner's random numbers: by scene, and how often was planned since it came."""
        self._n_planned += 1
        return stream(*self._dice, "motion", self._n_planned)

    def _say(self, what: str) -> None:
        self._doing = what
