"""Where pixels lie on a fitted solid: which face, and where on it. Pure.

Pixels are (n,). A pixel's ray is cut with the solid instead of lifting its own noisy depth, so the
faces come out flat and sharp. Tops are given in the solid's own axes; the sides of round and
six-sided solids by azimuth about the axis; the sides of boxes one by one.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.perception.solids import BALL_FLAT_M, Solid

ROUND_SIDES: Final = 72
MISS_M: Final = 0.0025
"""A ray that passes the solid at this distance or less still counts as hitting its rim."""

Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Surfaces:
    """Pixels laid onto a solid."""

    solid: Solid
    hit: Bools
    """(n,) the ray meets the solid, or nearly"""
    met: Bools
    """(n,) the ray meets the solid"""
    distance_m: Array
    """(n,) along the ray, where it does"""
    on_top: Bools
    """(n,)"""
    side: NDArray[np.int64]
    """(n,) for prisms the side's index, 0 where its normal is the solid's +x; -1 on top"""
    own_m: Array
    """(n, 3) in the solid's axes, from its middle"""
    cosine: Array
    """(n,) between the face's normal and the line of sight"""

    @property
    def azimuth_rad(self) -> Array:
        """(n,) about the axis, in the world."""
        return np.arctan2(self.own_m[:, 1], self.own_m[:, 0]) + self.solid.yaw_rad


def outline_of(solid: Solid) -> tuple[Array, Array]:
    """Azimuths (k,) in the solid's axes and distances (k,) of the flat sides of a prism."""
    a, b = solid.size_m
    if solid.kind == "box":
        return _turns(4), np.array([a, b, a, b]) / 2
    sides = 6 if solid.kind == "hexagonal prism" else ROUND_SIDES
    return _turns(sides), np.full(sides, a / 2)


def _turns(n: int) -> Array:
    return np.linspace(0.0, 2 * np.pi, n, endpoint=False)


def lay(solid: Solid, rays: Array, eye_m: Array) -> Surfaces:
    """Cut rays (n, 3), any length, from the eye with a solid."""
    middle = np.array([solid.x_m, solid.y_m, 0.5 * (solid.base_m + solid.top_m)])
    c, s = np.cos(solid.yaw_rad), np.sin(solid.yaw_rad)
    R_own_world = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    eye = R_own_world @ (eye_m - middle)
    d = rays @ R_own_world.T
    d = d / np.linalg.norm(d, axis=1, keepdims=True)
    return _on_ball(solid, eye, d) if solid.kind == "ball" else _on_prism(solid, eye, d)


def _on_prism(solid: Solid, eye: Array, d: Array) -> Surfaces:
    azimuths, distances = outline_of(solid)
    half = 0.5 * (solid.top_m - solid.base_m)
    normals = np.column_stack([np.cos(azimuths), np.sin(azimuths), np.zeros(len(azimuths))])
    normals = np.vstack([normals, [0.0, 0.0, 1.0]])
    offsets = np.append(distances, half)
    towards = d @ normals.T
    entering = np.where(towards < -1e-6, (offsets - normals @ eye) / towards, -np.inf)
    face = entering.argmax(1)
    depth = np.take_along_axis(entering, face[:, None], axis=1)
    own = eye + depth * d
    over = (own @ normals.T - offsets).max(1)
    over = np.maximum(over, -half - own[:, 2])
    on_top = face == len(azimuths)
    cosine = -np.take_along_axis(towards, face[:, None], axis=1)[:, 0]
    side = np.where(on_top, -1, face)
    return Surfaces(solid, over < MISS_M, over < 1e-9, depth[:, 0], on_top, side, own, cosine)


def _on_ball(solid: Solid, eye: Array, d: Array) -> Surfaces:
    radius = solid.size_m[0] / 2
    center = np.array([0.0, 0.0, -BALL_FLAT_M / 2])
    from_center = eye - center
    along = d @ from_center
    gap2 = (from_center @ from_center) - along**2
    hit = gap2 < (radius + MISS_M) ** 2
    depth = -along - np.sqrt(np.maximum(radius**2 - gap2, 0.0))
    normal = from_center + depth[:, None] * d
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    cosine = -np.einsum("ni,ni->n", normal, d)
    nowhere, none = np.full(len(d), -1), np.zeros(len(d), bool)
    met = gap2 < radius**2
    return Surfaces(solid, hit, met, depth, none, nowhere, radius * normal, cosine)
