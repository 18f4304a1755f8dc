"""Motion in cluttered scenes: poses that are reachable by construction must be reached."""

import time

import numpy as np
import pytest

from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.geometry import Array, inverse, rigid, rotation_z
from surefetch.common.messages import Box3d, ContainerReading, Estimate, Mask, Track
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.obstacles import obstacles_of
from surefetch.executor.motion.paths import LINE_STEP_M, Room, follow_line
from surefetch.executor.motion.planner import MotionPlanner, Tool
from surefetch.executor.robot import kinematics, ur10e

POSES = 500
POSES_PER_SCENE = 10
TOOL = Tool(width_m=0.08)


@pytest.mark.long
def test_reaches_99_percent_of_poses_that_are_reachable_by_construction() -> None:
    seconds, durations, missed = [], [], []
    for seed in range(POSES // POSES_PER_SCENE):
        rng = np.random.default_rng([9, seed])
        cell, scene = simulated_cell(), cluttered(simulated_cell(), rng)
        planner = MotionPlanner(cell)
        for _ in range(POSES_PER_SCENE):
            start, goal = reachable_pair(Room(cell, scene, TOOL.width_m), rng)
            began = time.perf_counter()
            try:
                durations.append(planner.to_pose(start, goal, scene, TOOL, rng).times_s[-1])
            except Infeasible as error:
                missed.append(f"scene {seed}: {error.refusal}: {error.why}")
            seconds.append(time.perf_counter() - began)
    p50, p95, worst = np.quantile(seconds, [0.5, 0.95, 1.0])
    print(f"\nreached {POSES - len(missed)}/{POSES}; planning p50 {p50:.3f} s, p95 {p95:.3f} s,")
    print(f"worst {worst:.3f} s; motion median {np.median(durations):.1f} s", *missed, sep="\n")
    assert len(missed) <= POSES // 100, missed


def cluttered(cell: Cell, rng: np.random.Generator) -> CollisionScene:
    """A container, two screens and nine bodies, as an estimate would tell them."""
    centers: list[Array] = []

    def place(radius_m: float) -> tuple[float, float]:
        for _ in range(200):
            xy = rng.uniform([0.75, -0.3], [1.15, 0.3])
            if all(np.hypot(*(xy - c[:2])) > radius_m + c[2] for c in centers):
                break
        centers.append(np.array([*xy, radius_m]))
        return float(xy[0]), float(xy[1])

    def box(radius_m: float, size: Array) -> Box3d:
        x, y = place(radius_m)
        sx, sy, sz = (float(v) for v in size)
        yaw = float(rng.uniform(-np.pi, np.pi))
        return Box3d(center_world_m=(x, y, sz / 2.0), size_m=(sx, sy, sz), yaw_rad=yaw)

    inner = rng.uniform([0.18, 0.14], [0.26, 0.20])
    container = _container(box(0.14, np.array([*(inner + 0.01), rng.uniform(0.06, 0.12)])), inner)
    screens = tuple(
        box(0.05, np.array([0.01, rng.uniform(0.06, 0.14), rng.uniform(0.08, 0.18)]))
        for _ in range(2)
    )
    bodies = [box(0.05, rng.uniform([0.025, 0.025, 0.025], [0.08, 0.08, 0.1])) for _ in range(9)]
    estimate = Estimate(
        tracks=tuple(_track(i, solid) for i, solid in enumerate(bodies)),
        container=container,
        cover="open",
        obstacles=screens,
        obstacle_points_world_m=np.zeros((0, 3), np.float32),
    )
    return CollisionScene(ur10e.camera_mount(cell.camera), obstacles_of(estimate))


def _container(outer: Box3d, inner: Array) -> ContainerReading:
    return ContainerReading(
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        mask=Mask(height=1, width=1, counts=(1,)),
        outer=outer,
        inner_size_m=(float(inner[0]), float(inner[1])),
        floor_z_m=0.005,
        rim_z_m=outer.size_m[2],
        complete=True,
        lid=None,
    )


def _track(i: int, solid: Box3d) -> Track:
    return Track(
        id=i,
        center_world_m=solid.center_world_m,
        solid=solid,
        points_world_m=np.zeros((0, 3), np.float32),
        hist=None,
        n_observations=1,
        y0=None,
        last_detection="d",
        last_step=0,
    )


def reachable_pair(room: Room, rng: np.random.Generator) -> tuple[Array, Array]:
    """A free start and a tcp pose that a known free path joins to it: half of the poses low.

    Both ends grow from home by free moves: a walk of random joint moves, and for half of the
    poses a straight line down between the obstacles until it is blocked or drawn to end.
    """
    home = np.radians(room.cell.home.q_deg)
    tcp = ur10e.tcp(room.width_m)
    start = _walk(home, room, rng) if rng.random() < 0.5 else home
    if rng.random() < 0.5:
        return start, ur10e.flange(_walk(home, room, rng)) @ tcp
    while True:
        x, y = rng.uniform([0.75, -0.3], [1.15, 0.3])
        R = rotation_z(rng.uniform(-np.pi, np.pi)) @ np.diag([1.0, -1.0, -1.0])
        above = rigid(R, np.array([x, y, 0.35])) @ inverse(tcp)
        for q in _hovering(above, home):
            if room.edge_free(home, q):
                return start, ur10e.flange(_down(q, room, rng)) @ tcp


def _hovering(T_world_flange: Array, near: Array) -> Array:
    """The four nearest configurations at a pose; none where it is out of reach."""
    try:
        return kinematics.solutions(T_world_flange, near)[:4]
    except Infeasible:
        return np.zeros((0, 6))


def _walk(q: Array, room: Room, rng: np.random.Generator) -> Array:
    """The end of five free random joint moves."""
    for _ in range(5):
        for _ in range(50):
            further = q + rng.normal(0.0, 0.5, 6)
            if room.edge_free(q, further):
                q = further
                break
    return q


def _down(q: Array, room: Room, rng: np.random.Generator) -> Array:
    T = ur10e.flange(q)
    T[2, 3] -= rng.uniform(0.1, 0.34)
    path = follow_line(q, T)
    free = 1
    while free < len(path) and room.free(path[free : free + 1]):
        free += 1
    margin = int(np.ceil(0.008 / LINE_STEP_M))  # not at the very edge of what is free
    lowest: Array = path[max(free - 1 - margin, 0)]
    return lowest
