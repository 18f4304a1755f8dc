"""Upright solids fitted to what is seen of them: their visible points and their silhouette. Pure.

Four kinds stand on a known support: cylinder, ball, box, hexagonal prism. Each is fitted by
Gauss-Newton with numeric derivatives; all objects, starts and derivatives of a frame run as one
batch. Shapes: b fits, n surface points, m silhouette pixels, k directions, p parameters.

Residuals are in units of their standard deviation: the distance of a surface point from the
solid's surface, and the distance of a silhouette pixel from the solid's projected outline.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array

Kind = Literal["cylinder", "ball", "box", "hexagonal prism"]
KINDS: Final[tuple[Kind, ...]] = ("cylinder", "ball", "box", "hexagonal prism")

N_POINTS: Final = 160
N_OUTLINE: Final = 48
BALL_FLAT_M: Final = 0.002
"""Balls are flattened by this where they stand."""
_N_COARSE: Final = 6
_CLIPS: Final = (15.0,) * _N_COARSE + (3.0,) * 5
"""Per iteration: residuals count up to this many standard deviations; at first a start that is off
must still see where to go."""
_CLIP: Final = _CLIPS[-1]
_STEP: Final = 1e-4
_CIRCLE: Final = np.arange(24) * (2 * np.pi / 24)
_HEXAGON: Final = np.arange(6) * (np.pi / 3) + np.pi / 6


@dataclass(frozen=True, eq=False)
class Seen:
    """What is seen of one object, sampled to fixed numbers."""

    points_m: Array
    """(n, 3) visible surface, world"""
    sigma_m: Array
    """(n,) standard deviation along the ray"""
    outline_px: Array
    """(m, 2) pixels of the silhouette that nothing nearer hides"""
    outline_weight: Array
    """(m,) 1 for a real sample, 0 for filling"""
    base_m: float
    """World z of what it stands on"""
    center_m: Array
    """(2,) first guess"""
    width_m: float
    """First guess"""
    top_m: float
    """World z, first guess"""
    yaw_rad: float
    """First guess"""


@dataclass(frozen=True, eq=False)
class View:
    """The camera, as far as projection needs it."""

    K: Array
    T_camera_world: Array
    eye_m: Array


@dataclass(frozen=True)
class Solid:
    """A fitted solid. Sizes are full lengths along its own axes; heights are world z."""

    kind: Kind
    x_m: float
    y_m: float
    yaw_rad: float
    size_m: tuple[float, float]
    base_m: float
    top_m: float
    rms: float
    """Clipped root mean square of the residuals, in standard deviations"""


def fit(objects: Sequence[Seen], view: View) -> list[dict[Kind, Solid]]:
    """The best solid of each kind for each object."""
    if not objects:
        return []
    by_kind: dict[Kind, list[Solid]] = {}
    for kind in ("cylinder", "ball", "box"):
        by_kind[kind] = _fit_kind(kind, objects, view, [_starts(kind, seen) for seen in objects])
    around = [
        _prisms_around(cylinder, seen)
        for cylinder, seen in zip(by_kind["cylinder"], objects, strict=True)
    ]
    by_kind["hexagonal prism"] = _fit_kind(
        "hexagonal prism", objects, view, around, _CLIPS[_N_COARSE:]
    )
    return [{kind: by_kind[kind][i] for kind in KINDS} for i in range(len(objects))]


@dataclass(frozen=True, eq=False)
class _Batch:
    """b fits at once; the arrays of `Seen`, stacked."""

    points: Array
    """(b, n, 3)"""
    sigma: Array
    rays: Array
    """(b, n, 3) unit directions from the eye"""
    outline: Array
    weight: Array
    base: Array
    """(b,)"""


def _fit_kind(
    kind: Kind,
    objects: Sequence[Seen],
    view: View,
    starts: Sequence[Array],
    clips: Sequence[float] = _CLIPS,
) -> list[Solid]:
    n_starts = len(starts[0])
    batch = _batch([seen for seen in objects for _ in range(n_starts)], view)
    params = np.concatenate(starts)
    damping = np.full(len(params), 1e-2)
    residuals = _residuals(kind, params, batch, view)
    for clip in clips:
        step = _gauss_newton(kind, params, residuals, damping, clip, batch, view)
        tried = params + step
        new_residuals = _residuals(kind, tried, batch, view)
        better = _cost(new_residuals, clip) < _cost(residuals, clip)
        params = np.where(better[:, None], tried, params)
        residuals = np.where(better[:, None], new_residuals, residuals)
        damping = np.where(better, damping * 0.3, damping * 10.0)
    cost = _cost(residuals, _CLIP)
    best = cost.reshape(len(objects), n_starts).argmin(1) + n_starts * np.arange(len(objects))
    return [
        _solid(kind, params[i], seen.base_m, float(np.sqrt(cost[i])))
        for i, seen in zip(best, objects, strict=True)
    ]


def _batch(objects: Sequence[Seen], view: View) -> _Batch:
    points = np.stack([seen.points_m for seen in objects])
    rays = points - view.eye_m
    distances = np.linalg.norm(rays, axis=2)
    return _Batch(
        points,
        np.stack([seen.sigma_m for seen in objects]),
        rays / distances[..., None],
        np.stack([seen.outline_px for seen in objects]),
        np.stack([seen.outline_weight for seen in objects]),
        np.array([seen.base_m for seen in objects]),
    )


def _starts(kind: Kind, seen: Seen) -> Array:
    """First guesses (starts, p).

    Parameters: x, y, then ball: radius; cylinder: radius, top; box: yaw, length, width, top;
    hexagonal prism, which starts from the cylinder: yaw, distance across flats, top.
    """
    x, y = seen.center_m
    width, top = seen.width_m, seen.top_m
    if kind == "ball":
        return np.array([[x, y, 0.5 * width]])
    if kind == "cylinder":
        return np.array([[x, y, 0.5 * width, top]])
    turns = seen.yaw_rad + np.array([0.0, np.pi / 6, np.pi / 3])
    return np.array([[x, y, yaw, width, width, top] for yaw in turns])


def _prisms_around(cylinder: Solid, seen: Seen) -> Array:
    """Six-sided prisms of the same area as a fitted cylinder, in turns of 10 degrees.

    A rough start would settle at any turn.
    """
    across = cylinder.size_m[0] * float(np.sqrt(np.pi / (2 * np.sqrt(3.0))))
    turns = seen.yaw_rad + np.arange(6) * (np.pi / 18)
    return np.array([[cylinder.x_m, cylinder.y_m, yaw, across, cylinder.top_m] for yaw in turns])


def _cost(residuals: Array, clip: float) -> Array:
    clipped: Array = np.minimum(residuals**2, clip**2).mean(1)
    return clipped


def _gauss_newton(
    kind: Kind,
    params: Array,
    residuals: Array,
    damping: Array,
    clip: float,
    batch: _Batch,
    view: View,
) -> Array:
    b, p = params.shape
    J = np.empty((b, residuals.shape[1], p))
    for j in range(p):
        moved = params.copy()
        moved[:, j] += _STEP
        J[:, :, j] = (_residuals(kind, moved, batch, view) - residuals) / _STEP
    weights = 1.0 / np.maximum(clip / _CLIP, np.abs(residuals)) ** 2
    weights = np.where(np.abs(residuals) > 2 * clip, 0.02 * weights, weights)
    JW = J * weights[:, :, None]
    A = np.einsum("bnp,bnq->bpq", JW, J)
    g = np.einsum("bnp,bn->bp", JW, residuals)
    diagonal = np.einsum("bpp->bp", A) * damping[:, None] + 1.0
    A[:, np.arange(p), np.arange(p)] += diagonal
    step = -np.linalg.solve(A, g[..., None])[..., 0]
    limit: Array = np.clip(step, -0.3 if kind in ("box", "hexagonal prism") else -0.02, 0.3)
    limit[:, :2] = np.clip(limit[:, :2], -0.015, 0.015)
    return limit


def _residuals(kind: Kind, params: Array, batch: _Batch, view: View) -> Array:
    """Of surface points and outline samples, (b, n + m)."""
    distance, normal = _distances(kind, params, batch)
    slant = np.abs(np.einsum("bni,bni->bn", normal, batch.rays))
    sigma = np.sqrt((batch.sigma * slant) ** 2 + 0.0006**2)
    outside = _outline_distances(kind, params, batch, view)
    outline = outside / 0.8 * batch.weight
    return np.concatenate([distance / sigma, outline], axis=1)


def _own(params: Array, yaw: Array | None, batch: _Batch) -> tuple[Array, Array]:
    dx = batch.points[..., 0] - params[:, 0:1]
    dy = batch.points[..., 1] - params[:, 1:2]
    if yaw is None:
        return dx, dy
    c, s = np.cos(yaw)[:, None], np.sin(yaw)[:, None]
    return dx * c + dy * s, dy * c - dx * s


def _distances(kind: Kind, params: Array, batch: _Batch) -> tuple[Array, Array]:
    """Signed distances (b, n) of the points from the surface, and its normals (b, n, 3) there."""
    z = batch.points[..., 2]
    if kind == "ball":
        r = params[:, 2:3]
        dx, dy = _own(params, None, batch)
        dz = z - (batch.base[:, None] + r - BALL_FLAT_M)
        length = np.sqrt(dx**2 + dy**2 + dz**2) + 1e-9
        return length - r, np.stack([dx, dy, dz], axis=-1) / length[..., None]
    if kind == "cylinder":
        dx, dy = _own(params, None, batch)
        length = np.hypot(dx, dy) + 1e-9
        side = length - params[:, 2:3]
        flat = np.stack([dx / length, dy / length, np.zeros_like(dx)], axis=-1)
        return _with_top(side, flat, z - params[:, 3:4])
    u, v = _own(params, params[:, 2], batch)
    if kind == "box":
        gaps = np.stack([np.abs(u) - params[:, 3:4] / 2, np.abs(v) - params[:, 4:5] / 2])
        angles = np.array([0.0, np.pi / 2])
        top = params[:, 5:6]
    else:
        angles = np.array([0.0, np.pi / 3, 2 * np.pi / 3])
        gaps = np.stack([np.abs(u * np.cos(a) + v * np.sin(a)) for a in angles])
        gaps = gaps - params[None, :, 3:4] / 2
        top = params[:, 4:5]
    which = gaps.argmax(0)
    side = np.take_along_axis(gaps, which[None], axis=0)[0]
    turn = angles[which] + params[:, 2:3]
    flat = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=-1)
    return _with_top(side, flat, z - top)


def _with_top(side: Array, flat: Array, over: Array) -> tuple[Array, Array]:
    on_top = over > side
    up = np.array([0.0, 0.0, 1.0])
    return np.where(on_top, over, side), np.where(on_top[..., None], up, flat)


def _corners(kind: Kind, params: Array, batch: _Batch, view: View) -> Array:
    """(b, c, 3) points whose projections' convex hull is the solid's outline."""
    x, y = params[:, 0:1], params[:, 1:2]
    if kind == "ball":
        return _rim_of_ball(params, batch, view)
    if kind == "cylinder":
        u, v = params[:, 2:3] * np.cos(_CIRCLE), params[:, 2:3] * np.sin(_CIRCLE)
        top = params[:, 3:4]
    elif kind == "box":
        a, b = params[:, 3:4] / 2, params[:, 4:5] / 2
        u, v = _turned(
            a * np.array([1.0, -1.0, -1.0, 1.0]), b * np.array([1.0, 1.0, -1.0, -1.0]), params
        )
        top = params[:, 5:6]
    else:
        r = params[:, 3:4] / np.sqrt(3.0)
        u, v = _turned(r * np.cos(_HEXAGON), r * np.sin(_HEXAGON), params)
        top = params[:, 4:5]
    base = np.broadcast_to(batch.base[:, None], u.shape)
    low = np.stack([x + u, y + v, base], axis=-1)
    high = np.stack([x + u, y + v, np.broadcast_to(top, u.shape)], axis=-1)
    return np.concatenate([low, high], axis=1)


def _turned(u: Array, v: Array, params: Array) -> tuple[Array, Array]:
    c, s = np.cos(params[:, 2:3]), np.sin(params[:, 2:3])
    return u * c - v * s, u * s + v * c


def _rim_of_ball(params: Array, batch: _Batch, view: View) -> Array:
    r = params[:, 2]
    center = np.column_stack([params[:, :2], batch.base + r - BALL_FLAT_M])
    away = center - view.eye_m
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    axis = away / distance
    across = np.cross(axis, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across, axis=1, keepdims=True) + 1e-9
    over = np.cross(axis, across)
    shift = (r[:, None] ** 2) / distance
    radius = r[:, None] * np.sqrt(np.maximum(0.0, 1.0 - (r[:, None] / distance) ** 2))
    ring = np.cos(_CIRCLE)[None, :, None] * across[:, None] + (
        np.sin(_CIRCLE)[None, :, None] * over[:, None]
    )
    rim: Array = (center - shift * axis)[:, None] + radius[:, :, None] * ring
    return rim


_UNIFORM: Final = np.arange(48) * (2 * np.pi / 48)


def _outline_distances(kind: Kind, params: Array, batch: _Batch, view: View) -> Array:
    """(b, m) signed pixels of the outline samples outside the solid's projection."""
    corners = _corners(kind, params, batch, view)
    R, t = view.T_camera_world[:3, :3], view.T_camera_world[:3, 3]
    uvw = (corners @ R.T + t) @ view.K.T
    pixels = uvw[..., :2] / uvw[..., 2:3]
    normals = _edge_normals(kind, pixels)
    reach = np.einsum("bkd,bcd->bkc", normals, pixels).max(2)
    gaps = np.einsum("bkd,bmd->bmk", normals, batch.outline) - reach[:, None, :]
    outside: Array = gaps.max(2)
    return outside


def _edge_normals(kind: Kind, pixels: Array) -> Array:
    """(b, k, 2) unit normals among which are those of the outline's edges."""
    if kind in ("ball", "cylinder"):
        circle = np.column_stack([np.cos(_UNIFORM), np.sin(_UNIFORM)])
        return np.broadcast_to(circle, (len(pixels), *circle.shape))
    half = pixels.shape[1] // 2
    low, high = pixels[:, :half], pixels[:, half:]
    edges = np.concatenate(
        [np.roll(low, -1, axis=1) - low, np.roll(high, -1, axis=1) - high, high - low], axis=1
    )
    edges /= np.linalg.norm(edges, axis=2, keepdims=True) + 1e-9
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
    return np.concatenate([normals, -normals], axis=1)


def _solid(kind: Kind, params: NDArray[np.float64], base: float, rms: float) -> Solid:
    values = [float(value) for value in params]
    x, y = values[0], values[1]
    if kind == "ball":
        r = abs(values[2])
        return Solid(kind, x, y, 0.0, (2 * r, 2 * r), base, base + 2 * r - BALL_FLAT_M, rms)
    if kind == "cylinder":
        r = abs(values[2])
        return Solid(kind, x, y, 0.0, (2 * r, 2 * r), base, values[3], rms)
    yaw = (values[2] + np.pi) % (2 * np.pi) - np.pi
    if kind == "box":
        return Solid(kind, x, y, yaw, (abs(values[3]), abs(values[4])), base, values[5], rms)
    across = abs(values[3])
    return Solid(kind, x, y, yaw, (across, across), base, values[4], rms)
