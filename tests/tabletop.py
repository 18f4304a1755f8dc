"""Small simulated tables for tests, and moves as a planner would time them."""

import numpy as np

from surefetch.common.geometry import Array, inverse, rigid
from surefetch.common.messages import Body, Container, Lighting, Marking, Scene, Shape
from surefetch.executor import kinematics, ur10e
from surefetch.executor.ports import Trajectory

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
