"""Paths: straight in joint space where that is free, else found by OMPL; straight lines in space.

Nothing here knows about time. Every path is checked at steps in which no point of the arm moves
more than the room's step. OMPL's random seed is global to the process: plan from one thread.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou
from scipy.spatial.transform import Rotation, Slerp

from surefetch.common.cell import Cell
from surefetch.common.geometry import Array, rigid
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.robot import kinematics, ur10e

STEP_M = 0.010
LINE_STEP_M = 0.004
LINE_STEP_RAD = float(np.radians(2.0))
BRANCH_JUMP_RAD = 0.25
"""Joints that move more within one step of a line have changed branch or met a singularity."""
LEVER_M = np.array([1.5, 1.5, 0.95, 0.45, 0.35, 0.30])
"""Farthest any point of arm, tool or camera can be from each joint's axis."""
WORKSPACE_SLACK_M = 1e-4
RRT_RANGE_RAD = 0.7
RRT_ROUNDS = ((0.8, 12_000), (2.5, 40_000))
"""Search box around start and goals in radians, and how many states may be checked in it."""
SHORTCUTS = 60
ROUNDING_RAD = (0.4, 0.2, 0.1, 0.05)


@dataclass(frozen=True, eq=False)
class Room:
    """Where the arm may be: joint limits, workspace box of the tcp, and no collision."""

    cell: Cell
    scene: CollisionScene
    width_m: float
    """Finger opening while moving"""
    step_m: float = STEP_M
    """No point of the arm moves more than this between checked states."""

    def refusal(self, q_rad: Array) -> Infeasible | None:
        """Why one of the configurations (n, 6) is not allowed, or None."""
        past = np.abs(q_rad) > ur10e.Q_MAX_RAD - kinematics.LIMIT_MARGIN_RAD + 1e-9
        if past.any():
            joint = ur10e.JOINTS[int(past.any(axis=0).argmax())]
            return Infeasible("limits", f"{joint} would come within 5 degrees of its limit")
        p = tcp_positions(q_rad, self.width_m)
        low, high = np.array([self.cell.workspace_min_m, self.cell.workspace_max_m])
        out = (p < low - WORKSPACE_SLACK_M) | (p > high + WORKSPACE_SLACK_M)
        if out.any():
            x, y, z = p[out.any(axis=1).argmax()]
            where = f"({x:.3f}, {y:.3f}, {z:.3f}) m"
            return Infeasible("limits", f"the fingertips would leave the workspace at {where}")
        hit = self.scene.first_collision(q_rad, self.width_m)
        if hit is None:
            return None
        return Infeasible("collision", f"the {hit[1][0]} would touch the {hit[1][1]}")

    def free(self, q_rad: Array) -> bool:
        """Whether all configurations (n, 6) are allowed."""
        return self.refusal(q_rad) is None

    def edge_free(self, q_a: Array, q_b: Array) -> bool:
        """Whether the straight joint move is allowed; coarse steps first, to fail early."""
        steps = densify(np.stack([q_a, q_b]), self.step_m)
        return self.free(steps[::-8]) and self.free(steps)


def tcp_positions(q_rad: Array, width_m: float) -> Array:
    """Positions (n, 3) of the tcp for configurations (n, 6)."""
    T = ur10e.flange(q_rad)
    tips: Array = T[:, :3, 3] + T[:, :3, 2] * ur10e.tcp(width_m)[2, 3]
    return tips


def densify(waypoints: Array, step_m: float = STEP_M) -> Array:
    """The polyline (m, 6) with steps so small that no point of the arm moves more than step_m."""
    pieces = [waypoints[:1]]
    for a, b in pairwise(waypoints):
        n = max(int(np.ceil((np.abs(b - a) * LEVER_M).sum() / step_m)), 1)
        pieces.append(a + (b - a) * (np.arange(1, n + 1) / n)[:, None])
    return np.concatenate(pieces)


def find_path(
    start_rad: Array, goals_rad: Array, room: Room, rng: np.random.Generator | None
) -> Array:
    """Waypoints (m, 6) from the start to one of the goals (k, 6), the nearest good one first.

    Without a generator only straight joint moves are tried.

    Raises:
        Infeasible: collision or limits when the start or every goal is not allowed; path when no
            way was found.
    """
    blocked = room.refusal(start_rad[None])
    if blocked is not None:
        raise Infeasible(blocked.refusal, f"the arm cannot start here: {blocked.why}")
    goals = _allowed(goals_rad, start_rad, room)
    for goal in goals:
        if room.edge_free(start_rad, goal):
            return np.stack([start_rad, goal])
    if rng is None:
        raise Infeasible("path", f"no straight joint move to {len(goals)} configurations is free")
    for margin_rad, budget in RRT_ROUNDS:
        found = _connect(start_rad, goals, room, margin_rad, budget, rng)
        if found is not None:
            return _shortcut(found, room, rng)
    raise Infeasible("path", f"no free path to any of {len(goals)} configurations was found")


def _allowed(goals_rad: Array, start_rad: Array, room: Room) -> Array:
    """Goals (k, 6) that are allowed and not much farther than the nearest such one."""
    efforts = kinematics.effort_s(goals_rad, start_rad)
    order = np.argsort(efforts, kind="stable")
    first: Infeasible | None = None
    kept: list[Array] = []
    nearest = np.inf
    for i in order:
        if efforts[i] > 2.0 * nearest + 0.5:
            break
        blocked = room.refusal(goals_rad[i][None])
        first = first or blocked
        if blocked is None:
            nearest = min(nearest, float(efforts[i]))
            kept.append(goals_rad[i])
    if not kept:
        assert first is not None, "there is at least one goal"
        raise first
    return np.array(kept)


class _EdgeChecker(ob.MotionValidator):  # type: ignore[misc]
    """Lets OMPL ask for a whole edge at once, and counts the states that this takes."""

    def __init__(self, information: Any, room: Room) -> None:
        super().__init__(information)
        self._room = room
        self.states_checked = 0

    def checkMotion(self, a: Any, b: Any, *_: Any) -> bool:
        q_a, q_b = _joints_of(a), _joints_of(b)
        self.states_checked += 1 + int((np.abs(q_b - q_a) * LEVER_M).sum() / self._room.step_m)
        return self._room.edge_free(q_a, q_b)


def _connect(
    start_rad: Array,
    goals_rad: Array,
    room: Room,
    margin_rad: float,
    budget: int,
    rng: np.random.Generator,
) -> Array | None:
    """RRT-Connect within a box around start and goals; None when the budget ran out."""
    ou.setLogLevel(ou.LogLevel.LOG_NONE)
    ou.RNG.setSeed(int(rng.integers(1, 2**31)))
    information = _information(np.vstack([start_rad, goals_rad]), margin_rad)
    checker = _EdgeChecker(information, room)
    information.setStateValidityChecker(lambda state: room.free(_joints_of(state)[None]))
    information.setMotionValidator(checker)
    information.setup()
    problem = ob.ProblemDefinition(information)
    problem.addStartState(_state_of(information, start_rad))
    ends = ob.GoalStates(information)
    for goal in goals_rad:
        ends.addState(_state_of(information, goal))
    problem.setGoal(ends)
    planner = og.RRTConnect(information)
    planner.setProblemDefinition(problem)
    planner.setRange(RRT_RANGE_RAD)
    planner.setup()
    planner.solve(ob.PlannerTerminationCondition(lambda: checker.states_checked > budget))
    if not problem.hasExactSolution():
        return None
    return np.array([_joints_of(state) for state in problem.getSolutionPath().getStates()])


def _information(around_rad: Array, margin_rad: float) -> Any:
    limit = ur10e.Q_MAX_RAD - kinematics.LIMIT_MARGIN_RAD
    bounds = ob.RealVectorBounds(6)
    for i in range(6):
        bounds.setLow(i, float(max(around_rad[:, i].min() - margin_rad, -limit[i])))
        bounds.setHigh(i, float(min(around_rad[:, i].max() + margin_rad, limit[i])))
    space = ob.RealVectorStateSpace(6)
    space.setBounds(bounds)
    return ob.SpaceInformation(space)


def _joints_of(state: Any) -> Array:
    return np.array([state[i] for i in range(6)])


def _state_of(information: Any, q_rad: Array) -> Any:
    state = information.allocState()
    for i in range(6):
        state[i] = float(q_rad[i])
    return state


def _shortcut(waypoints: Array, room: Room, rng: np.random.Generator) -> Array:
    """The same path with detours cut where the direct joint move is free."""
    path = waypoints
    for _ in range(SHORTCUTS):
        if len(path) == 2:
            break
        lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
        ends = np.concatenate([[0.0], np.cumsum(lengths)])
        a, b = np.sort(rng.uniform(0.0, ends[-1], 2))
        i, j = (int(np.clip(np.searchsorted(ends, s) - 1, 0, len(lengths) - 1)) for s in (a, b))
        if i == j:
            continue
        q_a = path[i] + (path[i + 1] - path[i]) * (a - ends[i]) / lengths[i]
        q_b = path[j] + (path[j + 1] - path[j]) * (b - ends[j]) / lengths[j]
        if room.edge_free(q_a, q_b):
            path = _without_repeats(np.vstack([path[: i + 1], q_a, q_b, path[j + 1 :]]))
    return path


def _without_repeats(path: Array) -> Array:
    moved = np.linalg.norm(np.diff(path, axis=0), axis=1) > 1e-9
    kept: Array = path[np.concatenate([[True], moved])]
    return kept


def rounded(waypoints: Array, radius_rad: float, step_m: float = STEP_M) -> Array:
    """A dense path (n, 6) along the polyline (m, 6), its corners replaced by parabolas.

    A corner is cut at most radius_rad before it and at most half of the shorter neighbour.
    """
    waypoints = _without_repeats(waypoints)
    pieces = [waypoints[:1]]
    for before, corner, after in zip(waypoints, waypoints[1:], waypoints[2:], strict=False):
        cut = min(
            radius_rad,
            float(np.linalg.norm(corner - before)) / 2.0,
            float(np.linalg.norm(after - corner)) / 2.0,
        )
        q_in = corner + (before - corner) * cut / np.linalg.norm(before - corner)
        q_out = corner + (after - corner) * cut / np.linalg.norm(after - corner)
        pieces += [q_in[None], _parabola(q_in, corner, q_out, step_m)]
    pieces.append(waypoints[-1:])
    return densify(_without_repeats(np.concatenate(pieces)), step_m)


def _parabola(q_in: Array, corner: Array, q_out: Array, step_m: float) -> Array:
    reach = ((np.abs(corner - q_in) + np.abs(q_out - corner)) * LEVER_M).sum()
    t = np.linspace(0.0, 1.0, max(int(np.ceil(reach / step_m)), 8) + 1)[1:, None]
    bent: Array = (1.0 - t) ** 2 * q_in + 2.0 * t * (1.0 - t) * corner + t**2 * q_out
    return bent


def follow_line(start_rad: Array, T_world_flange_goal: Array) -> Array:
    """Configurations (n, 6) that carry the flange straight from the start to a pose (4, 4).

    Position and orientation move in proportion, in steps of at most LINE_STEP_M and
    LINE_STEP_RAD; all in the start's branch.

    Raises:
        Infeasible: reach or limits on the way; path where the branch would have to change.
    """
    path = [start_rad]
    for T in _poses_between(ur10e.flange(start_rad), T_world_flange_goal):
        q = kinematics.nearest(T, path[-1])
        if np.abs(q - path[-1]).max() > BRANCH_JUMP_RAD:
            raise Infeasible("path", "a straight line would change the arm's branch on the way")
        path.append(q)
    return np.array(path)


def _poses_between(T_a: Array, T_b: Array) -> Iterator[Array]:
    """Flange poses on the line from a (left out) to b."""
    turn = Rotation.from_matrix(np.stack([T_a[:3, :3], T_b[:3, :3]]))
    angle = float((turn[0].inv() * turn[1]).magnitude())
    length = float(np.linalg.norm(T_b[:3, 3] - T_a[:3, 3]))
    n = max(int(np.ceil(max(length / LINE_STEP_M, angle / LINE_STEP_RAD))), 1)
    parts = np.arange(1, n + 1) / n
    turned = Slerp([0.0, 1.0], turn)(parts).as_matrix()
    for part, R in zip(parts, turned, strict=True):
        yield rigid(R, T_a[:3, 3] + (T_b[:3, 3] - T_a[:3, 3]) * part)
