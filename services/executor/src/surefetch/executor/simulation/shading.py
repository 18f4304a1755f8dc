"""Light and shadow on a rendered depth image (pure).

The simulator's renderer gives depth and which surface each pixel shows; colour is made here, so
that shadows fall where they must and every colour is exactly the scene's.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse
from surefetch.common.messages import Lighting

Image1 = NDArray[np.float32]
"""(h, w)"""
Image3 = NDArray[np.float32]
"""(h, w, 3)"""

SHADOW_BIAS_M = 0.0015
SHADOW_SLOPE_BIAS_M = 0.0015
GLOSS = 24.0
ROOM_RGB = (0.80, 0.82, 0.84)
"""Where nothing is hit."""


@dataclass(frozen=True, eq=False)
class Lamp:
    """What the light sees: a depth image (h, w) from its place; 0 where it hits nothing."""

    depth_m: Image1
    K: Array
    T_world_lamp: Array


def points_camera(depth_m: Image1, K: Array) -> Image3:
    """Camera-frame points (h, w, 3) of a depth image."""
    h, w = depth_m.shape
    out = np.empty((h, w, 3), np.float32)
    out[..., 0] = depth_m * ((np.arange(w, dtype=np.float32) - K[0, 2]) / K[0, 0])
    out[..., 1] = depth_m * ((np.arange(h, dtype=np.float32) - K[1, 2]) / K[1, 1])[:, None]
    out[..., 2] = depth_m
    return out


def normals(points: Image3) -> Image3:
    """Unit normals (h, w, 3) towards the camera, from the flatter neighbour on each axis."""
    across, down = _flatter_step(points, 1), _flatter_step(points, 0)
    n = np.empty_like(points)
    ax, ay, az = across[..., 0], across[..., 1], across[..., 2]
    dx, dy, dz = down[..., 0], down[..., 1], down[..., 2]
    n[..., 0] = az * dy - ay * dz
    n[..., 1] = ax * dz - az * dx
    n[..., 2] = ay * dx - ax * dy
    n /= (_length(n) + 1e-20)[..., None]
    return n


def _flatter_step(points: Image3, axis: int) -> Image3:
    """Difference to the next or from the previous pixel, whichever is shorter in depth."""
    step = np.diff(points, axis=axis)
    pad = [(0, 0), (0, 0), (0, 0)]
    pad[axis] = (0, 1)
    after = np.pad(step, pad, mode="edge")
    pad[axis] = (1, 0)
    before = np.pad(step, pad, mode="edge")
    flatter = np.abs(after[..., 2:]) <= np.abs(before[..., 2:])
    return np.where(flatter, after, before)


def lit(
    albedo: Image3,
    depth_m: Image1,
    K: Array,
    T_world_camera: Array,
    light: Lighting,
    lamp: Lamp | None,
) -> NDArray[np.uint8]:
    """The picture (h, w, 3): ambient and diffuse light, a highlight, shadows where a lamp is given.

    Source: Blinn, Models of light reflection for computer synthesized pictures (1977).
    """
    points = points_camera(depth_m, K)
    normal = normals(points)
    to_light = _direction_camera(light, T_world_camera)
    cosine = normal @ to_light
    sun = np.ones_like(depth_m)
    if lamp is not None:
        sun = unshadowed(points, cosine, T_world_camera, lamp)
    halfway = to_light - points / (_length(points) + 1e-9)[..., None]
    shine = np.einsum("hwc,hwc->hw", normal, halfway) / (_length(halfway) + 1e-9)
    shine = np.clip(shine, 0.0, 1.0) ** np.float32(GLOSS)
    strength = np.float32(light.ambient) + np.float32(light.diffuse) * np.maximum(cosine, 0.0) * sun
    picture = albedo * strength[..., None] + (np.float32(light.specular) * shine * sun)[..., None]
    picture[depth_m == 0.0] = ROOM_RGB
    rgb: NDArray[np.uint8] = np.clip(np.rint(picture * 255.0), 0, 255).astype(np.uint8)
    return rgb


def _length(vectors: Image3) -> Image1:
    length: Image1 = np.sqrt(np.einsum("hwc,hwc->hw", vectors, vectors))
    return length


def _direction_camera(light: Lighting, T_world_camera: Array) -> NDArray[np.float32]:
    direction = np.asarray(light.direction) / np.linalg.norm(light.direction)
    turned: NDArray[np.float32] = (T_world_camera[:3, :3].T @ direction).astype(np.float32)
    return turned


def unshadowed(points: Image3, cosine: Image1, T_world_camera: Array, lamp: Lamp) -> Image1:
    """Share (h, w) of the lamp that each point sees, 0 … 1, softened over neighbours.

    `cosine` is of the angle between a point's normal and the light: slanted surfaces span more
    depth within a pixel of the lamp's image, so they may lie deeper behind it.
    """
    T = (inverse(lamp.T_world_lamp) @ T_world_camera).astype(np.float32)
    at_lamp = points @ T[:3, :3].T + T[:3, 3]
    z = np.maximum(at_lamp[..., 2], np.float32(0.1))
    u = np.float32(lamp.K[0, 0]) * at_lamp[..., 0] / z + np.float32(lamp.K[0, 2])
    v = np.float32(lamp.K[1, 1]) * at_lamp[..., 1] / z + np.float32(lamp.K[1, 2])
    c = np.clip(cosine, 0.05, 1.0)
    slope = np.sqrt(1.0 - c * c) / c
    return _share_lit(lamp.depth_m, u, v, z - SHADOW_BIAS_M - SHADOW_SLOPE_BIAS_M * slope)


def _share_lit(map_m: Image1, u: Image1, v: Image1, nearest_m: Image1) -> Image1:
    """Four taps a pixel apart; outside the map everything is lit."""
    h, w = map_m.shape
    lit_taps = np.zeros(u.shape, np.float32)
    for du, dv in ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)):
        column = np.rint(u + du).astype(np.int32)
        row = np.rint(v + dv).astype(np.int32)
        inside = (column >= 0) & (column < w) & (row >= 0) & (row < h)
        seen = map_m[np.clip(row, 0, h - 1), np.clip(column, 0, w - 1)]
        lit_taps += ~inside | (seen == 0.0) | (seen >= nearest_m)
    return lit_taps / np.float32(4.0)
