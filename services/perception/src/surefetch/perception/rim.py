"""The rim of an open container: straight walls of one height around an interior. Pure."""

from dataclasses import replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.perception.rectangle import Rectangle
from surefetch.perception.surface import Floats, Surface

LEVEL_TOLERANCE_M: Final = 0.004
"""Points of one edge lie this near to its height."""
DEFAULT_FLOOR_M: Final = 0.004
"""A floor that is not seen has the usual thickness."""


def walls(
    points: Floats, heights: Floats, outline: Rectangle, level: float
) -> tuple[Rectangle, Rectangle, float]:
    """Outer and inner edges and the rim's height, from the points near the outline."""
    near = (heights > level - 0.012) & (heights < level + LEVEL_TOLERANCE_M)
    xy, z = points[near, :2].astype(np.float64), heights[near]
    for _ in range(2):
        outline = _straightened(xy, outline)
    bands = [_band(xy, outline, axis, side) for axis in (0, 1) for side in (0, 1)]
    thick = float(np.clip(np.median([hi - lo for lo, hi in bands]), 0.003, 0.015))
    middles = [0.5 * (lo + hi) for lo, hi in bands]
    center = Rectangle(outline.yaw_rad, (middles[0], middles[1]), (middles[2], middles[3]))
    on_rim = np.abs(center.inset(xy)) < 0.5 * thick
    rim = float(np.percentile(z[on_rim], 85)) if on_rim.sum() > 20 else level
    return center.grown(thick / 2), center.grown(-thick / 2), rim


def _side(
    xy: NDArray[np.float64], outline: Rectangle, axis: int, side: int, reach_m: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points near one side: their places along it and across it."""
    c, s = np.cos(outline.yaw_rad), np.sin(outline.yaw_rad)
    uv = (xy[:, 0] * c + xy[:, 1] * s, xy[:, 1] * c - xy[:, 0] * s)
    across, along = uv[axis], uv[1 - axis]
    at = (outline.u_m, outline.v_m)[axis][side]
    ends = (outline.u_m, outline.v_m)[1 - axis]
    near = (np.abs(across - at) < reach_m) & (along > ends[0] + 0.01) & (along < ends[1] - 0.01)
    return along[near], across[near]


def _straightened(xy: NDArray[np.float64], outline: Rectangle) -> Rectangle:
    """The outline turned by the common slope of its sides and moved onto them."""
    slopes, weights = [], []
    moved = [list(outline.u_m), list(outline.v_m)]
    for axis in (0, 1):
        for side in (0, 1):
            along, across = _side(xy, outline, axis, side, 0.008)
            if len(along) < 30:
                continue
            spread = along - along.mean()
            slope = float(spread @ (across - across.mean()) / (spread @ spread + 1e-9))
            slopes.append(slope if axis == 1 else -slope)
            weights.append(float(spread @ spread))
            moved[axis][side] = float(np.median(across))
    turn = float(np.average(slopes, weights=weights)) if slopes else 0.0
    turned = replace(outline, u_m=(moved[0][0], moved[0][1]), v_m=(moved[1][0], moved[1][1]))
    return _turned_about_center(turned, float(np.clip(turn, -0.05, 0.05)))


def _turned_about_center(outline: Rectangle, turn_rad: float) -> Rectangle:
    x, y = outline.center_m
    yaw = outline.yaw_rad + turn_rad
    c, s = np.cos(yaw), np.sin(yaw)
    u, v = x * c + y * s, y * c - x * s
    a, b = outline.size_m
    return replace(
        outline,
        yaw_rad=yaw,
        u_m=(float(u - a / 2), float(u + a / 2)),
        v_m=(float(v - b / 2), float(v + b / 2)),
    )


def _band(xy: NDArray[np.float64], outline: Rectangle, axis: int, side: int) -> tuple[float, float]:
    """Where a wall begins and ends, across it."""
    _, across = _side(xy, outline, axis, side, 0.012)
    if len(across) < 20:
        at = (outline.u_m, outline.v_m)[axis][side]
        return (at - 0.003, at + 0.003)
    return (float(np.percentile(across, 4)), float(np.percentile(across, 96)))


def floor_height(surface: Surface, inner: Rectangle, rim: float) -> float:
    """Height of the floor, from what is seen of it."""
    inset = inner.inset(surface.points_world_m[..., :2])
    inside = surface.valid & (inset > 0.012) & (surface.height_m < min(0.6 * rim, 0.02))
    heights = surface.height_m[inside]
    return float(np.median(heights)) if len(heights) > 50 else DEFAULT_FLOOR_M
