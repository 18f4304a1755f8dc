"""Triangle meshes of boxes, prisms, cylinders and balls, in the body's own axes (pure).

A body's origin is the centre of its bounding box; z is up. Faces turn counter-clockwise seen from
outside. Curved surfaces are low-poly: the software renderer pays for every triangle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.common.messages import Shape

ROUND_SEGMENTS = 48
BALL_RINGS = 20
BALL_FLAT_M = 0.002
"""How much is cut off under a ball, so that it rests."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Vertices (n, 3) in metres and triangles (m, 3) of vertex indices."""

    vertices_m: Array
    triangles: NDArray[np.int64]


def merged(meshes: Sequence[Mesh]) -> Mesh:
    """All of them as one mesh: one draw call."""
    starts = np.cumsum([0, *(len(mesh.vertices_m) for mesh in meshes[:-1])])
    return Mesh(
        np.concatenate([mesh.vertices_m for mesh in meshes]),
        np.concatenate([mesh.triangles + k for mesh, k in zip(meshes, starts, strict=True)]),
    )


def box(size_m: Sequence[float], center_m: Sequence[float] = (0.0, 0.0, 0.0)) -> Mesh:
    """A box of full sizes (3,) along the axes."""
    x, y = np.asarray(size_m[:2]) / 2.0
    outline = np.array([[x, -y], [x, y], [-x, y], [-x, -y]])
    solid = prism(outline, size_m[2])
    return Mesh(solid.vertices_m + np.asarray(center_m), solid.triangles)


def prism(outline_m: Array, height_m: float) -> Mesh:
    """An upright prism over a convex outline (n, 2), counter-clockwise, centred at z = 0."""
    n = len(outline_m)
    bottom = np.column_stack([outline_m, np.full(n, -height_m / 2.0)])
    top = np.column_stack([outline_m, np.full(n, height_m / 2.0)])
    k = np.arange(n)
    after = (k + 1) % n
    sides = np.concatenate(
        [np.column_stack([k, after, n + after]), np.column_stack([k, n + after, n + k])]
    )
    fan = np.arange(1, n - 1)
    zero = np.zeros_like(fan)
    lids = [np.column_stack([zero, fan + 1, fan]), np.column_stack([zero, fan, fan + 1]) + n]
    return Mesh(np.concatenate([bottom, top]), np.concatenate([sides, *lids]))


def outline(shape: Shape, size_m: Sequence[float]) -> Array:
    """The footprint (n, 2) of an upright shape, counter-clockwise about the origin.

    A hexagonal prism turns a flat side to -x and +x and a corner to -y and +y.
    """
    x, y = size_m[0] / 2.0, size_m[1] / 2.0
    if shape in ("cube", "block"):
        return np.array([[x, -y], [x, y], [-x, y], [-x, -y]])
    if shape == "hexagonal prism":
        corners = np.radians([30.0, 90.0, 150.0, 210.0, 270.0, 330.0])
        return np.column_stack([x * np.cos(corners) / np.cos(np.pi / 6.0), y * np.sin(corners)])
    angles = (np.arange(ROUND_SEGMENTS) + 0.5) * 2.0 * np.pi / ROUND_SEGMENTS
    return np.column_stack([x * np.cos(angles), y * np.sin(angles)])


def ball(diameter_m: float, height_m: float) -> Mesh:
    """A sphere cut flat at the bottom to this height; the origin is at half the height."""
    radius = diameter_m / 2.0
    lowest = np.arcsin(np.clip((radius - height_m) / radius, -1.0, 1.0))
    latitudes = np.linspace(lowest, np.pi / 2.0, BALL_RINGS + 1)[:-1]
    angles = np.arange(ROUND_SEGMENTS) * 2.0 * np.pi / ROUND_SEGMENTS
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    layers = [
        np.column_stack([radius * np.cos(a) * ring, np.full(ROUND_SEGMENTS, radius * np.sin(a))])
        for a in latitudes
    ]
    poles = np.array([[0.0, 0.0, radius - height_m], [0.0, 0.0, radius]])
    vertices = np.concatenate([*layers, poles])
    vertices[:, 2] += ball_center_m(diameter_m, height_m)
    return Mesh(vertices, _ball_triangles(ROUND_SEGMENTS, len(latitudes)))


def ball_center_m(diameter_m: float, height_m: float) -> float:
    """Where the sphere's centre is above the body's origin (negative: below)."""
    return (height_m - diameter_m) / 2.0


def _ball_triangles(n: int, rings: int) -> NDArray[np.int64]:
    """Bands between rings of n vertices, a fan below the first and one above the last."""
    k = np.arange(n)
    after = (k + 1) % n
    parts = []
    for low in range(0, (rings - 1) * n, n):
        parts.append(np.column_stack([low + k, low + after, low + n + after]))
        parts.append(np.column_stack([low + k, low + n + after, low + n + k]))
    bottom, top, last = rings * n, rings * n + 1, (rings - 1) * n
    parts.append(np.column_stack([np.full(n, bottom), after, k]))
    parts.append(np.column_stack([np.full(n, top), last + k, last + after]))
    return np.concatenate(parts)
