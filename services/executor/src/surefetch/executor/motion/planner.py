"""Motions as the skills ask for them: to a pose, to joints, along a line; planned, timed, checked.

The only way from a wish to a `Trajectory`. Every trajectory starts and ends at rest, and its
samples were checked again after timing: limits, workspace and collisions.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from surefetch.common.cell import Cell, View
from surefetch.common.geometry import Array, inverse
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.paths import (
    ROUNDING_RAD,
    STEP_M,
    Room,
    densify,
    find_path,
    follow_line,
    rounded,
    tcp_positions,
)
from surefetch.executor.motion.timing import Limits, time_joint_move, time_path
from surefetch.executor.ports import Trajectory
from surefetch.executor.robot import kinematics, ur10e, views

NEAR_TABLE_M = 0.10
LAST_M = 0.03
STEPS_M = (STEP_M, STEP_M / 2.0, STEP_M / 4.0)
"""Steps of path checks: finer when the timed path meets what the coarse steps stepped over."""


@dataclass(frozen=True, eq=False)
class Tool:
    """The hand while it moves."""

    width_m: float
    """Finger opening"""
    careful: bool = False
    """Something is held, or is within 100 mm: the slower tcp speed everywhere."""


class MotionPlanner:
    """Plans for one cell. Keeps no state: the same questions get the same answers."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._limits = Limits.of(cell.speeds)

    def configurations(
        self, T_world_tcp: Array, near_rad: Array, scene: CollisionScene, tool: Tool
    ) -> Array:
        """All allowed configurations (k, 6) for a tcp pose (4, 4), nearest first.

        Raises:
            Infeasible: reach, limits, or collision of the nearest.
        """
        T_world_flange = T_world_tcp @ inverse(ur10e.tcp(tool.width_m))
        room = Room(self._cell, scene, tool.width_m)
        found = kinematics.solutions(T_world_flange, near_rad)
        by_branch: dict[bytes, Infeasible | None] = {}
        for q in found:
            if (branch := _branch(q)) not in by_branch:
                by_branch[branch] = room.refusal(q[None])
        allowed = found[[by_branch[_branch(q)] is None for q in found]]
        if not len(allowed):
            raise next(refusal for refusal in by_branch.values() if refusal is not None)
        return allowed

    def to_joints(
        self,
        start_rad: Array,
        goals_rad: Array,
        scene: CollisionScene,
        tool: Tool,
        rng: np.random.Generator | None,
    ) -> Trajectory:
        """A trajectory to the best of the goals (k, 6); a straight joint move without a generator.

        Raises:
            Infeasible: collision or limits at the start or at every goal; path when none is found.
        """
        why = ""
        for step_m in STEPS_M:
            room = Room(self._cell, scene, tool.width_m, step_m)
            waypoints = find_path(start_rad, np.atleast_2d(goals_rad), room, rng)
            trajectory = self._timed(waypoints, room, tool)
            refusal = self.recheck(trajectory, scene, tool)
            if refusal is None:
                return trajectory
            why = refusal.why
        raise Infeasible("path", f"the timed path is not free: {why}")

    def to_pose(
        self,
        start_rad: Array,
        T_world_tcp: Array,
        scene: CollisionScene,
        tool: Tool,
        rng: np.random.Generator,
    ) -> Trajectory:
        """A trajectory that brings the tcp to a pose (4, 4). Raises Infeasible."""
        goals = self.configurations(T_world_tcp, start_rad, scene, tool)
        return self.to_joints(start_rad, goals, scene, tool, rng)

    def to_view(
        self,
        start_rad: Array,
        view: View,
        scene: CollisionScene,
        tool: Tool,
        rng: np.random.Generator,
    ) -> Trajectory:
        """A trajectory that brings the camera to a view of the cell. Raises Infeasible."""
        goals = kinematics.solutions(views.flange_pose(self._cell, view), start_rad)
        return self.to_joints(start_rad, goals, scene, tool, rng)

    def line(
        self, start_rad: Array, T_world_tcp: Array, scene: CollisionScene, tool: Tool
    ) -> Array:
        """Configurations (n, 6) of a straight line of the tcp, checked but not timed.

        Raises:
            Infeasible: reach, limits, path or collision on the way.
        """
        goal = T_world_tcp @ inverse(ur10e.tcp(tool.width_m))
        path = follow_line(start_rad, goal)
        refusal = Room(self._cell, scene, tool.width_m).refusal(path)
        if refusal is not None:
            raise refusal
        return path

    def straight(
        self,
        start_rad: Array,
        T_world_tcp: Array,
        scene: CollisionScene,
        tool: Tool,
        *,
        slow_end: bool = False,
    ) -> Trajectory:
        """A trajectory that carries the tcp on a straight line to a pose (4, 4).

        Args:
            start_rad: (6,), which also fixes the branch.
            T_world_tcp: Goal; orientation turns in proportion.
            scene: Its allowed pairs say what may be touched on the way.
            tool: The hand.
            slow_end: The last 30 mm at the cell's slowest speed, for an approach.

        Raises:
            Infeasible: reach, limits, path or collision on the way.
        """
        path = self.line(start_rad, T_world_tcp, scene, tool)
        limit = np.full(len(path), self._cell.speeds.tcp_near_m_s)
        if slow_end:
            p = tcp_positions(path, tool.width_m)
            limit[np.linalg.norm(p - p[-1], axis=1) < LAST_M] = self._cell.speeds.tcp_last_30mm_m_s
        timed = time_path(path, self._limits, limit, tool.width_m)
        refusal = self.recheck(timed, scene, tool)
        if refusal is not None:
            raise refusal
        return timed

    def recheck(
        self, trajectory: Trajectory, scene: CollisionScene, tool: Tool
    ) -> Infeasible | None:
        """Why the samples of a timed path are not allowed, or None."""
        return Room(self._cell, scene.for_recheck(), tool.width_m).refusal(trajectory.q_rad)

    def _timed_joint_move(self, waypoints: Array, tool: Tool) -> Trajectory:
        path = densify(waypoints)
        limit = self._tcp_limit(path, tool)
        if (limit == limit[0]).all():
            return time_joint_move(
                waypoints[0], waypoints[-1], self._limits, float(limit[0]), tool.width_m
            )
        return time_path(path, self._limits, limit, tool.width_m)

    def _timed(self, waypoints: Array, room: Room, tool: Tool) -> Trajectory:
        """The polyline without stops where rounded corners are free, else with a stop at each."""
        if len(waypoints) == 2:
            return self._timed_joint_move(waypoints, tool)
        for radius_rad in ROUNDING_RAD:
            path = rounded(waypoints, radius_rad, room.step_m)
            if room.free(path):
                limit = self._tcp_limit(path, tool)
                return time_path(path, self._limits, limit, tool.width_m)
        legs = [
            self._timed_joint_move(waypoints[i : i + 2], tool) for i in range(len(waypoints) - 1)
        ]
        return joined(legs)

    def _tcp_limit(self, path: Array, tool: Tool) -> Array:
        """Allowed tcp speeds (n,) along a path: slower near the table and when careful."""
        speeds = self._cell.speeds
        low = tcp_positions(path, tool.width_m)[:, 2] < NEAR_TABLE_M
        return np.where(low | tool.careful, speeds.tcp_near_m_s, speeds.tcp_free_m_s)


def _branch(q_rad: Array) -> bytes:
    """The same for configurations (6,) that differ by whole turns only."""
    angles: Array = np.round(np.concatenate([np.sin(q_rad), np.cos(q_rad)]), 6) + 0.0
    return angles.tobytes()


def joined(parts: Sequence[Trajectory]) -> Trajectory:
    """Trajectories one after another; each starts where the one before ended."""
    times, q = [parts[0].times_s], [parts[0].q_rad]
    for part in parts[1:]:
        times.append(part.times_s[1:] + times[-1][-1])
        q.append(part.q_rad[1:])
    return Trajectory(np.concatenate(times), np.concatenate(q))
