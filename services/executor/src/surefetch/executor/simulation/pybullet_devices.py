"""Arm, gripper and camera of the simulated cell, behind the same ports as the hardware."""

import time

import numpy as np

from surefetch.common.errors import DeviceFault
from surefetch.common.geometry import Array, intrinsics
from surefetch.executor.ports import Devices, Image, StopRequested, Trajectory
from surefetch.executor.robot import kinematics, views
from surefetch.executor.simulation.pybullet_cell import PybulletCell
from surefetch.executor.simulation.pybullet_world import STEP_S
from surefetch.executor.simulation.sensor_noise import noisy_depth, noisy_rgb

START_RAD = 0.02
LEFT_PATH_RAD = 0.10
STOP_S = 0.25
"""Time in which a stop slows the motion along its path to nothing."""
REST_S = 0.10
STILL_M_S = 0.002
STALLED_STEPS = 24
GRIPPER_S = 6.0
NEAR_TARGET_M = 0.0005
BLOCKED_M = 0.001


def pybullet_devices(simulated: PybulletCell, *, real_time: bool = False) -> Devices:
    """The three devices of a simulated cell."""
    pace = Pace(real_time)
    return Devices(
        arm=PybulletArm(simulated, pace),
        gripper=PybulletGripper(simulated, pace),
        camera=PybulletCamera(simulated),
    )


class Pace:
    """Lets simulated time run free, or holds it to the wall clock."""

    def __init__(self, real_time: bool) -> None:
        self._real_time = real_time

    def started(self) -> float:
        """Now; the start for `wait`."""
        return time.monotonic()

    def wait(self, started: float, elapsed_s: float) -> None:
        """In real time, sleep until this much simulated time may have passed."""
        if self._real_time:
            time.sleep(max(0.0, started + elapsed_s - time.monotonic()))


class PybulletArm:
    """Torque-limited motors that follow a trajectory at 240 Hz."""

    def __init__(self, simulated: PybulletCell, pace: Pace) -> None:
        self._simulated = simulated
        self._pace = pace

    def joints_rad(self) -> Array:
        """(6,) measured."""
        return self._simulated.robot.joints_rad()

    def follow(self, trajectory: Trajectory, stop: StopRequested) -> bool:
        """Drive the trajectory; see `ports.Arm`.

        A move that ends at a view ends with that view's arrival error, approached in proportion to
        the time, so that the joints measure it. A stop runs the trajectory's own clock down to a
        halt, so that the arm stays on its path.
        """
        robot = self._simulated.robot
        reference = Reference(trajectory, self._arrival_offset(trajectory.q_rad[-1]))
        if np.abs(robot.joints_rad() - trajectory.q_rad[0]).max() > START_RAD:
            raise DeviceFault("the arm is not where the trajectory starts; nothing was moved")
        started, steps = self._pace.started(), 0
        at_s, rate, stopping = 0.0, 1.0, False
        while at_s < reference.duration_s and rate > 0.0:
            stopping = stopping or stop()
            rate = max(0.0, rate - STEP_S / STOP_S) if stopping else 1.0
            at_s = min(at_s + rate * STEP_S, reference.duration_s)
            wanted = reference.joints_rad(at_s)
            robot.drive(wanted, rate * reference.speeds_rad_s(at_s))
            robot.step()
            steps += 1
            self._pace.wait(started, steps * STEP_S)
            off = float(np.abs(robot.joints_rad() - wanted).max())
            if off > LEFT_PATH_RAD:
                self._rest(robot.joints_rad())
                raise DeviceFault(
                    f"the arm left its path by {np.degrees(off):.1f} degrees; it has come to rest"
                )
        end = reference.joints_rad(at_s)
        self._rest(end)
        off = float(np.abs(robot.joints_rad() - end).max())
        if off > START_RAD:
            raise DeviceFault(f"the arm is held {np.degrees(off):.1f} degrees off its path's end")
        return at_s >= reference.duration_s

    def _rest(self, q_rad: Array) -> None:
        """Hold these joints until the arm stands still."""
        self._simulated.robot.drive(q_rad, np.zeros(6))
        for _ in range(round(REST_S / STEP_S)):
            self._simulated.robot.step()

    def _arrival_offset(self, end_rad: Array) -> Array:
        """(6,) what the arm adds to the end of a trajectory that ends at a view."""
        view = views.view_at(self._simulated.cell, end_rad)
        if view is None:
            return np.zeros(6)
        found = kinematics.solutions(self._simulated.flange_on_arrival(view), end_rad)
        offset: Array = found[0] - end_rad
        return offset


class Reference:
    """A trajectory at any time, with an offset that grows over it."""

    def __init__(self, trajectory: Trajectory, offset_rad: Array) -> None:
        self.duration_s = float(trajectory.times_s[-1])
        self._times_s = trajectory.times_s
        share = (trajectory.times_s / self.duration_s)[:, None]
        smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        self._q_rad = trajectory.q_rad + smooth * offset_rad

    def joints_rad(self, at_s: float) -> Array:
        """(6,)."""
        k = min(max(int(np.searchsorted(self._times_s, at_s)), 1), len(self._times_s) - 1)
        before_s, after_s = self._times_s[k - 1], self._times_s[k]
        share = min(max((at_s - before_s) / (after_s - before_s), 0.0), 1.0)
        q: Array = self._q_rad[k - 1] + share * (self._q_rad[k] - self._q_rad[k - 1])
        return q

    def speeds_rad_s(self, at_s: float) -> Array:
        """(6,)."""
        later = min(at_s + STEP_S, self.duration_s)
        speeds: Array = (self.joints_rad(later) - self.joints_rad(at_s)) / STEP_S
        return speeds


class PybulletGripper:
    """Two coupled fingers; how a closed hand holds is the cell's grip model."""

    def __init__(self, simulated: PybulletCell, pace: Pace) -> None:
        self._simulated = simulated
        self._pace = pace

    def width_m(self) -> float:
        """Measured."""
        return self._simulated.robot.width_m()

    def move(self, width_m: float, force_n: float, stop: StopRequested) -> float:
        """Open or close; see `ports.Gripper`."""
        robot = self._simulated.robot
        closing = width_m < robot.width_m()
        if not closing:
            robot.hand.release()
        robot.grip(width_m, force_n)
        started, still = self._pace.started(), 0
        for steps in range(1, round(GRIPPER_S / STEP_S)):
            robot.step()
            self._pace.wait(started, steps * STEP_S)
            still = still + 1 if robot.finger_speed_m_s() < STILL_M_S else 0
            reached = abs(robot.width_m() - width_m) < NEAR_TARGET_M
            if still >= STALLED_STEPS or (reached and still > 2) or stop():
                break
        if closing:
            self._simulated.closed()
        return robot.width_m()

    def grip_detected(self) -> bool:
        """The fingers were asked to close further than they can."""
        robot = self._simulated.robot
        return robot.width_m() - robot.target_width_m() > BLOCKED_M


class PybulletCamera:
    """Pictures from where the camera truly is, with a sensor's faults."""

    def __init__(self, simulated: PybulletCell) -> None:
        self._simulated = simulated

    def capture(self) -> Image:
        """A fresh image. The n-th one from a view in a cover state has the same noise always."""
        simulated, spec = self._simulated, self._simulated.world.scene.camera
        K = intrinsics(spec.width, spec.height, spec.vertical_fov_deg)
        T = simulated.T_world_camera_true()
        picture = simulated.world.render(T, K, spec.width, spec.height)
        simulated.keep_segmentation(picture.segmentation)
        rng = simulated.next_image_stream()
        depth_m = noisy_depth(picture.depth_m, picture.rgb, rng)
        return Image(rgb=noisy_rgb(picture.rgb, rng), depth_m=depth_m, K=K)
