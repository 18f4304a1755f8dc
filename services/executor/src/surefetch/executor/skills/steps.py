"""Planned motions with what they were checked against, so that they can be checked again."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array, rigid
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.planner import MotionPlanner, Tool
from surefetch.executor.ports import Trajectory
from surefetch.executor.robot import ur10e

SAME_JOINTS_RAD = 0.01


@dataclass(frozen=True, eq=False)
class Step:
    """One motion from rest to rest."""

    label: str
    trajectory: Trajectory
    tool: Tool
    scene: CollisionScene

    @property
    def start_rad(self) -> Array:
        """(6,)."""
        start: Array = self.trajectory.q_rad[0]
        return start

    @property
    def end_rad(self) -> Array:
        """(6,)."""
        end: Array = self.trajectory.q_rad[-1]
        return end

    def backwards(self, label: str) -> "Step":
        """The same way back, at the same speeds."""
        times = self.trajectory.times_s
        back = Trajectory(times[-1] - times[::-1], self.trajectory.q_rad[::-1])
        return Step(label, back, self.tool, self.scene)


def check_again(motion: MotionPlanner, steps: Sequence[Step], q_rad: Array) -> None:
    """Check planned steps once more, from where the arm stands (6,).

    Raises:
        Infeasible: path when the arm stands elsewhere; limits or collision on the way.
    """
    at = q_rad
    for step in steps:
        if np.abs(step.start_rad - at).max() > SAME_JOINTS_RAD:
            raise Infeasible("path", f'the arm is not where the motion "{step.label}" starts')
        refusal = motion.recheck(step.trajectory, step.scene, step.tool)
        if refusal is not None:
            raise refusal
        at = step.end_rad


def raised(T_world: Array, by_m: float) -> Array:
    """A pose (4, 4) moved straight up."""
    return rigid(np.eye(3), np.array([0.0, 0.0, by_m])) @ T_world


def line(
    motion: MotionPlanner,
    label: str,
    start_rad: Array,
    T_world_flange: Array,
    scene: CollisionScene,
    tool: Tool,
    *,
    slow_end: bool = False,
) -> Step:
    """A straight line of the tcp to where the flange is at a pose (4, 4). Raises Infeasible."""
    goal = T_world_flange @ ur10e.tcp(tool.width_m)
    trajectory = motion.straight(start_rad, goal, scene, tool, slow_end=slow_end)
    return Step(label, trajectory, tool, scene)
