"""Points around made-up objects, for tests of grasp proposers."""

from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from surefetch.common.cell import simulated_cell
from surefetch.common.geometry import Array, inverse, rotation_z, transform
from surefetch.common.messages import Shape
from surefetch.executor.grasping.ports import GraspPose
from surefetch.executor.robot import ur10e
from surefetch.executor.robot.hand import Hand, rg6
from surefetch.executor.simulation.scene_meshes import ball, outline, prism

HAND: Hand = rg6(ur10e.camera_mount(simulated_cell().camera))
SPACING_M = 0.005
THIN_TO_M = 0.002
SHAPES: tuple[Shape, ...] = ("cube", "block", "cylinder", "ball", "hexagonal prism")


@dataclass(frozen=True)
class Upright:
    """A shape on the table; sizes as in `messages.Body`."""

    shape: Shape
    size_m: tuple[float, float, float]
    at_m: tuple[float, float] = (0.9, 0.0)
    yaw_rad: float = 0.0
    on_m: float = 0.0
    """World z of what it stands on"""

    def points(self) -> Array:
        """(n, 3) on its whole surface."""
        x, y, z = self.size_m
        mesh = ball(x, z) if self.shape == "ball" else prism(outline(self.shape, (x, y)), z)
        corners = mesh.vertices_m[mesh.triangles]
        local = _thinned(np.concatenate([_on_triangle(a, b, c) for a, b, c in corners]))
        turned = local @ rotation_z(self.yaw_rad).T
        placed: Array = turned + np.array([*self.at_m, self.on_m + z / 2.0])
        return placed


def _on_triangle(a: Array, b: Array, c: Array) -> Array:
    """Points of a triangle, at most SPACING_M apart, its corners among them."""
    n = max(int(np.ceil(max(np.linalg.norm(b - a), np.linalg.norm(c - a)) / SPACING_M)), 1)
    u, v = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n)
    inside = u + v <= 1.0 + 1e-9
    points: Array = a + u[inside][:, None] * (b - a) + v[inside][:, None] * (c - a)
    return points


def _thinned(points_m: Array) -> Array:
    """One of the points in every small cube: the triangles of round bodies are narrow."""
    _, first = np.unique(np.floor(points_m / THIN_TO_M), axis=0, return_index=True)
    thinned: Array = points_m[first]
    return thinned


def wall(center_m: tuple[float, float], size_m: tuple[float, float, float]) -> Array:
    """Points (n, 3) of an upright wall on the table."""
    return Upright("block", size_m, center_m).points()


def fence(gap_m: float, height_m: float, half_m: tuple[float, float]) -> Array:
    """Four walls around (0.9, 0), this far from an object of these half sizes."""
    x, y = half_m[0] + gap_m, half_m[1] + gap_m
    return np.concatenate(
        [
            wall((0.9 + x, 0.0), (0.004, 2.0 * y, height_m)),
            wall((0.9 - x, 0.0), (0.004, 2.0 * y, height_m)),
            wall((0.9, y), (2.0 * x, 0.004, height_m)),
            wall((0.9, -y), (2.0 * x, 0.004, height_m)),
        ]
    )


def cloud(own: Array, *others: Array) -> tuple[Array, NDArray[np.bool_]]:
    """All points, and the mask of the first."""
    points = np.concatenate([own, *others])
    mask = np.zeros(len(points), dtype=np.bool_)
    mask[: len(own)] = True
    return points, mask


@st.composite
def uprights(draw: st.DrawFn, shapes: tuple[Shape, ...] = SHAPES) -> Upright:
    """An object of the vocabulary's sizes anywhere in the working area."""
    shape = draw(st.sampled_from(shapes))
    width, height = draw(st.floats(0.025, 0.08)), draw(st.floats(0.025, 0.10))
    sizes: dict[Shape, tuple[float, float, float]] = {
        "cube": (width, width, width),
        "block": (1.6 * width, width, height),
        "cylinder": (width, width, height),
        "ball": (width, width, width - 0.002),
        "hexagonal prism": (width, width / np.cos(np.pi / 6.0), height),
    }
    return Upright(
        shape,
        sizes[shape],
        (draw(st.floats(0.75, 1.15)), draw(st.floats(-0.3, 0.3))),
        draw(st.floats(-np.pi, np.pi)),
    )


def touched_by_hand(grasp: GraspPose, points_m: Array, width_m: float, back_m: float) -> bool:
    """Whether a finger or the gripper's body holds a point, at an opening, so far back.

    An account of its own, from the robot's tables: boxes at the flange.
    """
    T = grasp.T_world_flange.copy()
    T[:3, 3] -= back_m * T[:3, 2]
    local = transform(inverse(T), points_m)
    solids = [(center, ur10e.FINGER_SIZE_M) for center in ur10e.finger_centers(width_m)]
    solids += [
        (np.asarray(s.center_m), s.size_m) for s in ur10e.GRIPPER_SHAPES if isinstance(s, ur10e.Box)
    ]
    return any(
        bool((np.abs(local - center) < np.asarray(size) / 2.0).all(axis=1).any())
        for center, size in solids
    )
