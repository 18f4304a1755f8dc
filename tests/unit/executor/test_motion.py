import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from surefetch.common.cell import simulated_cell
from surefetch.common.geometry import Array, rigid
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.obstacles import NamedBox, Obstacles
from surefetch.executor.motion.paths import (
    LEVER_M,
    Room,
    densify,
    find_path,
    rounded,
    tcp_positions,
)
from surefetch.executor.motion.planner import MotionPlanner, Tool, joined
from surefetch.executor.motion.timing import Limits, time_joint_move, time_path
from surefetch.executor.ports import Trajectory
from surefetch.executor.robot import ur10e

CELL = simulated_cell()
HOME = np.radians(CELL.home.q_deg)
TOOL = Tool(width_m=0.08)
PLANNER = MotionPlanner(CELL)
LIMITS = Limits.of(CELL.speeds)
NOTHING = Obstacles((), np.zeros((0, 3)))
BARE = CollisionScene(ur10e.camera_mount(CELL.camera), NOTHING)
DOWN = np.diag([1.0, -1.0, -1.0])
MOVES = arrays(np.float64, 6, elements=st.floats(-0.4, 0.4))


def walled() -> CollisionScene:
    """A wall between the left and the right half of the working area."""
    wall = NamedBox(
        "wall", rigid(np.eye(3), np.array([0.95, 0.0, 0.2])), np.array([0.6, 0.02, 0.4])
    )
    return CollisionScene(BARE.T_flange_camera, Obstacles((wall,), np.zeros((0, 3))))


def at(x: float, y: float, z: float) -> Array:
    return rigid(DOWN, np.array([x, y, z]))


def rng() -> np.random.Generator:
    return np.random.default_rng(4)


def assert_inside_limits(motion: Trajectory, tcp_limit_m_s: float) -> None:
    dt = np.diff(motion.times_s)
    assert (dt > 0.0).all()
    speed = np.diff(motion.q_rad, axis=0) / dt[:, None]
    assert (np.abs(speed) <= LIMITS.speed_rad_s * 1.001).all()
    change = np.diff(speed, axis=0, prepend=0.0, append=0.0) / dt[0]  # from rest to rest
    assert np.abs(change).max() <= LIMITS.acceleration_rad_s2 * 1.01
    tcp = np.linalg.norm(np.diff(tcp_positions(motion.q_rad, TOOL.width_m), axis=0), axis=1) / dt
    assert tcp.max() <= tcp_limit_m_s * 1.001


@given(MOVES)
def test_a_joint_move_stays_on_its_line_and_inside_every_limit(move: Array) -> None:
    motion = time_joint_move(HOME, HOME + move, LIMITS, 0.5, TOOL.width_m)
    assert motion.q_rad[0] == pytest.approx(HOME)
    assert motion.q_rad[-1] == pytest.approx(HOME + move)
    length = np.linalg.norm(move)
    if length > 1e-6:
        along = (motion.q_rad - HOME) @ move / length**2
        assert np.abs(motion.q_rad - HOME - along[:, None] * move).max() < 1e-9
    assert_inside_limits(motion, 0.5)


@settings(max_examples=20, deadline=None)
@given(MOVES, MOVES, st.floats(0.05, 0.5))
def test_a_rounded_path_is_timed_inside_every_limit_and_not_left(
    first: Array, second: Array, tcp_limit_m_s: float
) -> None:
    path = rounded(np.array([HOME, HOME + first, HOME + first + second]), 0.2)
    motion = time_path(path, LIMITS, np.full(len(path), tcp_limit_m_s), TOOL.width_m)
    assert motion.q_rad[[0, -1]] == pytest.approx(path[[0, -1]])
    assert_inside_limits(motion, tcp_limit_m_s)
    away = np.linalg.norm(motion.q_rad[:, None] - densify(path, 0.003)[None], axis=2).min(axis=1)
    assert away.max() < 0.01


@given(MOVES)
def test_no_point_moves_farther_than_a_step_between_checked_states(move: Array) -> None:
    steps = np.diff(densify(np.array([HOME, HOME + move]), 0.01), axis=0)
    assert (np.abs(steps) @ LEVER_M).max() <= 0.01 + 1e-12


def test_a_free_move_is_straight_in_joint_space() -> None:
    goals = PLANNER.configurations(at(0.95, 0.1, 0.2), HOME, BARE, TOOL)
    path = find_path(HOME, goals, Room(CELL, BARE, TOOL.width_m), rng())
    assert len(path) == 2
    assert path[1] == pytest.approx(goals[0])


def test_a_wall_is_passed_without_touching_it_and_the_same_seed_gives_the_same_motion() -> None:
    scene = walled()
    start = PLANNER.configurations(at(0.95, 0.25, 0.05), HOME, scene, TOOL)[0]
    motions = [PLANNER.to_pose(start, at(0.95, -0.25, 0.05), scene, TOOL, rng()) for _ in (1, 2)]
    assert (motions[0].q_rad == motions[1].q_rad).all()
    motion = motions[0]
    assert motion.q_rad[0] == pytest.approx(start)
    reached = ur10e.flange(motion.q_rad[-1]) @ ur10e.tcp(TOOL.width_m)
    assert reached == pytest.approx(at(0.95, -0.25, 0.05), abs=1e-6)
    assert scene.for_recheck().first_collision(motion.q_rad, TOOL.width_m) is None
    assert tcp_positions(motion.q_rad, TOOL.width_m)[:, 2].max() > 0.3  # it went around
    assert_inside_limits(motion, CELL.speeds.tcp_free_m_s)


def test_a_line_keeps_the_tcp_on_it_and_its_end_slow() -> None:
    start = PLANNER.configurations(at(0.95, 0.1, 0.15), HOME, BARE, TOOL)[0]
    motion = PLANNER.straight(start, at(0.95, 0.1, 0.01), BARE, TOOL, slow_end=True)
    p = tcp_positions(motion.q_rad, TOOL.width_m)
    assert np.abs(p[:, :2] - [0.95, 0.1]).max() < 1e-4
    assert p[-1] == pytest.approx([0.95, 0.1, 0.01], abs=1e-6)
    speed = np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(motion.times_s)
    assert speed.max() <= CELL.speeds.tcp_near_m_s * 1.001
    assert speed[p[1:, 2] < 0.035].max() <= CELL.speeds.tcp_last_30mm_m_s * 1.001
    assert_inside_limits(motion, CELL.speeds.tcp_near_m_s)


def test_a_held_object_is_carried_slowly() -> None:
    careful = Tool(TOOL.width_m, careful=True)
    motion = PLANNER.to_pose(HOME, at(0.95, 0.1, 0.3), BARE, careful, rng())
    assert_inside_limits(motion, CELL.speeds.tcp_near_m_s)


@pytest.mark.parametrize("view", CELL.views, ids=lambda view: view.name)
def test_a_view_is_reached_by_the_camera(view: object) -> None:
    row = next(row for row in CELL.views if row == view)
    motion = PLANNER.to_view(HOME, row, BARE, TOOL, rng())
    T = ur10e.flange(motion.q_rad[-1]) @ BARE.T_flange_camera
    look = np.asarray(CELL.look_at_m) - T[:3, 3]
    assert T[:3, 2] @ look == pytest.approx(row.distance_m, abs=1e-6)


@pytest.mark.parametrize(
    ("goal", "scene", "refusal"),
    [
        (at(1.9, 0.0, 0.3), BARE, "reach"),
        (at(0.70, 0.8, 0.3), BARE, "limits"),
        (at(0.95, 0.1, 0.002), BARE, "limits"),
        (at(0.95, 0.0, 0.2), walled(), "collision"),
    ],
)
def test_refusals_name_the_check(goal: Array, scene: CollisionScene, refusal: str) -> None:
    with pytest.raises(Infeasible) as caught:
        PLANNER.to_pose(HOME, goal, scene, TOOL, rng())
    assert caught.value.refusal == refusal


def test_a_pose_behind_a_wall_without_a_way_around_has_no_path() -> None:
    center, size = np.array([0.9, 0.0, 0.8]), np.array([1.3, 0.02, 1.6])
    scene = CollisionScene(
        BARE.T_flange_camera,
        Obstacles((NamedBox("wall", rigid(np.eye(3), center), size),), np.zeros((0, 3))),
    )
    start = PLANNER.configurations(at(0.7, 0.4, 0.1), HOME, scene, TOOL)[0]
    with pytest.raises(Infeasible) as caught:
        PLANNER.to_pose(start, at(0.7, -0.4, 0.1), scene, TOOL, rng())
    assert caught.value.refusal == "path"


def test_joined_motions_follow_each_other_in_time() -> None:
    there = time_joint_move(HOME, HOME + 0.1, LIMITS, 0.5, TOOL.width_m)
    back = time_joint_move(HOME + 0.1, HOME, LIMITS, 0.5, TOOL.width_m)
    both = joined([there, back])
    assert (np.diff(both.times_s) > 0.0).all()
    assert both.times_s[-1] == pytest.approx(there.times_s[-1] + back.times_s[-1])
    assert both.q_rad[[0, -1]] == pytest.approx(np.stack([HOME, HOME]))


def test_a_line_that_would_change_branch_is_refused() -> None:
    q = np.radians([-20.0, -60.0, 20.0, -50.0, -90.0, 70.0])
    beyond = ur10e.flange(q)
    beyond[:3, 3] += beyond[:3, 3] * [0.2, 0.2, 0.0]
    with pytest.raises(Infeasible) as caught:
        PLANNER.line(q, beyond @ ur10e.tcp(TOOL.width_m), BARE, TOOL)
    assert caught.value.refusal in ("reach", "path")


@given(st.floats(1e-9, 1e-3))
def test_however_short_a_path_is_it_is_timed_inside_its_limits(share: float) -> None:
    path = np.stack([HOME, HOME + share, HOME + 2.0 * share])
    motion = time_path(path, LIMITS, np.full(3, 0.1), TOOL.width_m)
    assert motion.q_rad[-1] == pytest.approx(path[-1], abs=1e-9)
    assert_inside_limits(motion, 0.1)
