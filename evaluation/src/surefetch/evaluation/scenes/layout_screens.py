"""Screens that hide a body from a camera by a wanted share (pure).

Seen from the eye, `d` points to the body along the table and `n` to its left; the body's footprint
spans `d` and `n` about its centre.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.geometry import Array, rotation_z
from surefetch.common.messages import Screen, Shape, Xyz
from surefetch.evaluation.scenes.ground import Rectangle
from surefetch.executor.simulation.scene_meshes import outline

THICKNESS_M: Final = 0.008
GAP_M: Final = (0.012, 0.060)
WIDTH_M: Final = (0.060, 0.140)
HEIGHT_M: Final = (0.050, 0.180)


@dataclass(frozen=True, eq=False)
class Sight:
    """A body as an eye sees it along the table."""

    eye_m: Array
    """(3,)"""
    xy_m: Array
    """(2,) of the body"""
    top_m: float
    distance_m: float
    d: Array
    n: Array
    d_span_m: tuple[float, float]
    n_span_m: tuple[float, float]

    @classmethod
    def of(cls, eye_m: Array, xy_m: Array, size_m: Xyz, shape: Shape, yaw_rad: float) -> "Sight":
        """From where the eye and the body are."""
        away = xy_m - eye_m[:2]
        distance = float(np.hypot(*away))
        d = away / distance
        n = np.array([-d[1], d[0]])
        footprint = outline(shape, size_m) @ rotation_z(yaw_rad)[:2, :2].T
        along, across = footprint @ d, footprint @ n
        return cls(
            eye_m,
            xy_m,
            size_m[2],
            distance,
            d,
            n,
            (float(along.min()), float(along.max())),
            (float(across.min()), float(across.max())),
        )


def beside(sight: Sight, share: float, side: float, rng: np.random.Generator) -> Screen | None:
    """A high screen in front that leaves 1 - share of the body's width in sight at one side.

    Args:
        sight: Of the body to hide.
        share: 0 … 1.
        side: +1 leaves the left end in sight, -1 the right end.
        rng: Draws gap and margins.
    """
    gap = rng.uniform(*GAP_M)
    at = sight.distance_m + sight.d_span_m[0] - gap - THICKNESS_M / 2.0
    scale = at / sight.distance_m
    edge = scale * edge_of(sight, share, side)
    end = scale * sight.n_span_m[0 if side > 0 else 1]
    far = end - side * rng.uniform(0.005, 0.020)
    if abs(edge - far) < WIDTH_M[0]:
        far = edge - side * WIDTH_M[0]
    rear = sight.distance_m + sight.d_span_m[1]
    height = _at_height(sight, at, rear, sight.top_m) + rng.uniform(0.0, 0.015)
    return _screen(sight, at, (edge + far) / 2.0, abs(edge - far), max(height, 0.080))


def edge_of(sight: Sight, share: float, side: float) -> float:
    """Where along `n` a hidden share of the body's width ends, in metres from its centre."""
    right, left = sight.n_span_m
    seen = (1.0 - share) * (left - right)
    return left - seen if side > 0 else right + seen


def below(sight: Sight, share: float, rng: np.random.Generator) -> Screen | None:
    """A low, wide screen in front that leaves the upper 1 - share of the body in sight."""
    gap = rng.uniform(*GAP_M)
    at = sight.distance_m + sight.d_span_m[0] - gap - THICKNESS_M / 2.0
    front, rear = (sight.distance_m + v for v in sight.d_span_m)
    lowest = np.arctan2(sight.eye_m[2], front)
    highest = np.arctan2(sight.eye_m[2] - sight.top_m, rear)
    height = sight.eye_m[2] - at * np.tan(lowest + share * (highest - lowest))
    right, left = (at / sight.distance_m * v for v in sight.n_span_m)
    margin = rng.uniform(0.010, 0.025)
    width = max(left - right + 2.0 * margin, WIDTH_M[0])
    return _screen(sight, at, (left + right) / 2.0, width, float(height))


def right_wall(sight: Sight, eye_m: Array, rng: np.random.Generator) -> Screen | None:
    """A wall at the body's right that hides its top from this other eye."""
    at = sight.n_span_m[0] - rng.uniform(0.012, 0.045) - THICKNESS_M / 2.0
    origin = np.array([(eye_m[:2] - sight.xy_m) @ sight.d, (eye_m[:2] - sight.xy_m) @ sight.n])
    corners = np.array([[a, b] for a in sight.d_span_m for b in sight.n_span_m])
    if origin[1] >= at:
        return None
    share = (at - origin[1]) / (corners[:, 1] - origin[1])
    crossing = origin[0] + share * (corners[:, 0] - origin[0])
    heights = eye_m[2] + share * (sight.top_m - eye_m[2])
    low, high = crossing.min() - 0.004, crossing.max() + rng.uniform(0.004, 0.015)
    length, height = float(high - low), float(heights.max() + rng.uniform(0.0, 0.012))
    if length > WIDTH_M[1] + 0.02 or not HEIGHT_M[0] <= height <= HEIGHT_M[1]:
        return None
    xy = sight.xy_m + sight.d * (low + high) / 2.0 + sight.n * at
    yaw = float(np.arctan2(sight.n[1], sight.n[0]))
    return Screen(
        size_m=(THICKNESS_M, max(length, WIDTH_M[0]), max(height, 0.080)),
        position_world_m=(float(xy[0]), float(xy[1]), 0.0),
        yaw_rad=yaw,
    )


def standing(one: Screen) -> Rectangle:
    """The ground under a screen."""
    x, y, _ = one.position_world_m
    return Rectangle(x, y, (one.size_m[0], one.size_m[1]), one.yaw_rad)


def _at_height(sight: Sight, at: float, rear: float, z_m: float) -> float:
    """How high the line from the eye to a point z_m high at `rear` passes at `at`."""
    return float(sight.eye_m[2] + (z_m - sight.eye_m[2]) * at / rear)


def _screen(sight: Sight, at: float, across: float, width: float, height: float) -> Screen | None:
    if not WIDTH_M[0] - 1e-9 <= width <= WIDTH_M[1] or not HEIGHT_M[0] <= height <= HEIGHT_M[1]:
        return None
    xy = sight.eye_m[:2] + sight.d * at + sight.n * across
    return Screen(
        size_m=(THICKNESS_M, width, height),
        position_world_m=(float(xy[0]), float(xy[1]), 0.0),
        yaw_rad=float(np.arctan2(sight.d[1], sight.d[0])),
    )
