"""One command on the devices: what moved, what was measured, how long it took."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.messages import Motion
from surefetch.executor.ports import Devices, Trajectory
from surefetch.executor.robot import ur10e
from surefetch.executor.skills.situation import Memory
from surefetch.executor.skills.steps import Step
from surefetch.executor.stop_latch import StopLatch

PICTURE_S = 0.04
"""Between the samples of a recorded motion"""
GRIPPER_S = 0.15
"""A finger motion's time beside its travel: to start, and to feel that it has ended"""
EMPTY_M = 0.003
"""Closed on nothing, the fingers are nearer than this."""


class Halted(Exception):
    """A stop was asked for; the arm is at rest."""


class Failed(Exception):
    """What was tried did not come about; the text says what was measured."""


@dataclass(eq=False)
class Execution:
    """Drives the devices and keeps the record. One for each command."""

    devices: Devices
    latch: StopLatch
    force_n: float
    say: Callable[[str], None]
    """Told in a few words what is being done"""
    moved: Callable[[Motion], None]
    """Given every motion when it has ended"""
    memory: Memory
    """Of what the hand holds and has put down; follows what happens"""
    motions: list[Motion] = field(default_factory=list)
    checks: dict[str, bool] = field(default_factory=dict)
    duration_s: float = 0.0
    """Modelled time of all motions"""
    driving_s: float = 0.0
    """Time spent driving, by the clock"""

    def follow(self, step: Step) -> None:
        """Drive one step to its end.

        Raises:
            Halted: a stop came before or while it moved.
            DeviceFault: the arm could not; it is at rest.
        """
        width, arrived = self.devices.gripper.width_m(), False
        with self._moving(step.label):
            try:
                arrived = self.devices.arm.follow(step.trajectory, self.latch.asked)
            finally:
                driven = driven_part(step.trajectory, self.devices.arm.joints_rad(), arrived)
                self._keep(step.label, driven, np.full(len(driven.times_s), width))
        if not arrived:
            raise Halted

    def follow_all(self, steps: Sequence[Step]) -> None:
        """Drive steps one after another; see `follow`."""
        for step in steps:
            self.follow(step)

    def grip(self, label: str, width_m: float) -> float:
        """Move the fingers; the width reached. Raises Halted."""
        gripper = self.devices.gripper
        before = gripper.width_m()
        with self._moving(label):
            reached = gripper.move(width_m, self.force_n, self.latch.asked)
        took_s = abs(reached - before) / ur10e.GRIPPER_SPEED_M_S + GRIPPER_S
        still = np.tile(self.devices.arm.joints_rad(), (2, 1))
        moved = Trajectory(np.array([0.0, took_s]), still)
        self._keep(label, moved, np.array([before, reached]))
        if self.latch.asked():
            raise Halted
        return reached

    def check(self, name: str, passed: bool, why: str) -> None:
        """Note a measurement that decides. Raises Failed when it did not pass."""
        self.checks[name] = bool(passed)
        if not passed:
            raise Failed(why)

    def gripped(self) -> bool:
        """Whether the fingers press on something, by force and by width."""
        gripper = self.devices.gripper
        return gripper.grip_detected() and gripper.width_m() > EMPTY_M

    @contextmanager
    def _moving(self, label: str) -> Iterator[None]:
        """Around a motion: nothing begins after a stop. Raises Halted."""
        self.say(label)
        began = time.perf_counter()
        with self.latch.moving():
            if self.latch.asked():
                raise Halted
            try:
                yield
            finally:
                self.driving_s += time.perf_counter() - began

    def _keep(self, label: str, driven: Trajectory, width_m: Array) -> None:
        motion = Motion(
            label=label, times_s=driven.times_s, q_rad=driven.q_rad, gripper_width_m=width_m
        )
        self.motions.append(motion)
        self.duration_s += float(driven.times_s[-1])
        self.moved(motion)


def driven_part(trajectory: Trajectory, q_rad: Array, arrived: bool) -> Trajectory:
    """The part of a trajectory that was driven, thinned out, ending at the measured joints (6,).

    Where it was cut short is taken from the joints: the sample nearest to them.
    """
    last = len(trajectory.times_s) - 1
    if not arrived:
        last = max(int(np.abs(trajectory.q_rad - q_rad).max(axis=1).argmin()), 1)
    total_s = float(trajectory.times_s[last])
    times = np.linspace(0.0, total_s, max(int(np.ceil(total_s / PICTURE_S)), 1) + 1)
    q = np.stack([np.interp(times, trajectory.times_s, joint) for joint in trajectory.q_rad.T], 1)
    q[-1] = q_rad
    return Trajectory(times, q)
