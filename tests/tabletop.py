"""Small simulated tables for tests, and moves as a planner would time them."""

import numpy as np

from surefetch.common.geometry import Array, inverse, rigid, rotation_z, transform
from surefetch.common.messages import (
    Body,
    Box3d,
    Container,
    ContainerReading,
    Estimate,
    Lid,
    Lighting,
    Marking,
    Mask,
    Scene,
    Shape,
    Track,
)
from surefetch.executor.ports import Trajectory
from surefetch.executor.robot import kinematics, ur10e
from surefetch.executor.simulation import scene_bodies
from surefetch.executor.simulation.scene_meshes import Mesh

LIGHTING = Lighting(direction=(-0.4, 0.5, 1.0), ambient=0.45, diffuse=0.6, specular=0.05)
RED, BLUE, WHITE = (0.78, 0.12, 0.10), (0.12, 0.28, 0.75), (0.95, 0.95, 0.93)
DOWN = np.diag([1.0, -1.0, -1.0])


def body(
    name: str,
    shape: Shape = "cube",
    size_m: tuple[float, float, float] = (0.05, 0.05, 0.05),
    at_m: tuple[float, float] = (0.90, 0.0),
    marking: Marking | None = None,
    mass_kg: float = 0.15,
) -> Body:
    """A loose body on the table."""
    return Body(
        name=name,
        shape=shape,
        size_m=size_m,
        rgb=RED,
        marking=marking,
        mass_kg=mass_kg,
        position_world_m=(*at_m, 0.0),
        yaw_rad=0.0,
    )


def scene(*bodies: Body, container: Container | None = None, seed: int = 3) -> Scene:
    """A table with these bodies."""
    return Scene(
        family="visible",
        seed=seed,
        generator_version=1,
        bodies=bodies,
        container=container,
        screens=(),
        lighting=LIGHTING,
        table_rgb=(0.72, 0.66, 0.58),
    )


def box(covered: bool) -> Container:
    """An open box in the middle of the working area, or the same with its lid on."""
    return Container(
        kind="open box",
        inner_size_m=(0.18, 0.24),
        wall_height_m=0.07,
        wall_thickness_m=0.005,
        floor_thickness_m=0.005,
        rgb=(0.45, 0.30, 0.18),
        position_world_m=(1.02, 0.03, 0.0),
        yaw_rad=0.15,
        covered=covered,
        lid_rgb=(0.60, 0.60, 0.62),
    )


def move(start_rad: Array, end_rad: Array, duration_s: float = 2.0) -> Trajectory:
    """Straight in joint space, from rest to rest, by the quintic law."""
    times_s = np.linspace(0.0, duration_s, 60)
    share = (times_s / duration_s)[:, None]
    smooth = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return Trajectory(times_s=times_s, q_rad=start_rad + smooth * (end_rad - start_rad))


def above(tip_m: tuple[float, float, float], near_rad: Array, width_m: float) -> Array:
    """Joints (6,) that bring the fingertips here, pointing down, the fingers opening along y."""
    T_world_tcp = rigid(DOWN, np.asarray(tip_m))
    joints: Array = kinematics.solutions(T_world_tcp @ inverse(ur10e.tcp(width_m)), near_rad)[0]
    return joints


def estimate_of(table: Scene, *, covered: bool | None = None) -> Estimate:
    """What a perfect perception would say of a scene: tracks are numbered as its bodies.

    `covered` says whether the lid is still on; None: as the scene began.
    """
    box = table.container
    lid_on = box is not None and (box.covered if covered is None else covered)
    return Estimate(
        tracks=tuple(track_of(one, k) for k, one in enumerate(table.bodies)),
        container=None if box is None else reading_of(box, lid_on),
        cover="covered" if lid_on else "open",
        obstacles=tuple(
            _box3d(wall.position_world_m, wall.size_m, wall.yaw_rad) for wall in table.screens
        ),
        obstacle_points_world_m=np.zeros((0, 3), np.float32),
    )


def track_of(one: Body, number: int) -> Track:
    """A body as a track: its box, and points all over its surface."""
    solid = _box3d(one.position_world_m, one.size_m, one.yaw_rad)
    T = rigid(rotation_z(one.yaw_rad), np.asarray(solid.center_world_m))
    points = transform(T, _surface(scene_bodies.mesh_of(one)))
    return Track(
        id=number,
        center_world_m=solid.center_world_m,
        solid=solid,
        points_world_m=points.astype(np.float32),
        hist=None,
        n_observations=1,
        y0="MU",
        last_detection=f"detection {number}",
        last_step=0,
    )


def _surface(mesh: Mesh, n: int = 400) -> Array:
    """Points (n, 3) spread evenly over a mesh."""
    rng = np.random.default_rng(5)
    a, b, c = (mesh.vertices_m[mesh.triangles[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    k = rng.choice(len(areas), n, p=areas / areas.sum())
    u, v = np.sort(rng.uniform(size=(2, n)), axis=0)
    points: Array = u[:, None] * a[k] + (v - u)[:, None] * b[k] + (1.0 - v)[:, None] * c[k]
    return points


def reading_of(box: Container, lid_on: bool) -> ContainerReading:
    """A container as read by a perfect perception."""
    t, h = box.wall_thickness_m, box.wall_height_m
    across, along = (v + 2.0 * t for v in box.inner_size_m)
    x, y, z = box.position_world_m
    lid = None
    if lid_on:
        o = 2.0 * scene_bodies.LID_OVERHANG_M
        thick, knob = scene_bodies.LID_THICKNESS_M, scene_bodies.KNOB_HEIGHT_M
        wide = scene_bodies.KNOB_WIDTH_M
        lid = Lid(
            plate=_box3d((x, y, z + h), (across + o, along + o, thick), box.yaw_rad),
            knob=_box3d((x, y, z + h + thick), (wide, wide, knob), box.yaw_rad),
        )
    return ContainerReading(
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        mask=Mask(height=1, width=1, counts=(1,)),
        outer=_box3d(box.position_world_m, (across, along, h), box.yaw_rad),
        inner_size_m=box.inner_size_m,
        floor_z_m=z + box.floor_thickness_m,
        rim_z_m=z + h,
        complete=True,
        lid=lid,
    )


def _box3d(
    bottom_m: tuple[float, float, float], size_m: tuple[float, float, float], yaw_rad: float
) -> Box3d:
    x, y, z = bottom_m
    return Box3d(center_world_m=(x, y, z + size_m[2] / 2.0), size_m=size_m, yaw_rad=yaw_rad)
