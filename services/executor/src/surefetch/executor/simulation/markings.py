"""A marking as a coloured patch on one face of a body, in the body's own axes (pure).

A face is unrolled to a flat convex outline (u to the right, v up, seen from outside), the marking
is cut out of it so that it covers its share of the face, and the pieces are laid back on the
surface. Flat faces are whole. On a cylinder the side face is a sector of 90 degrees; on a ball the
same within 45 degrees of latitude, and its top the cap within 45 degrees; on a hexagonal prism a
sector of 60 degrees: in front one flat side, on the right the two halves beside a corner.

stripe: a bar across the whole face. dot: an ellipse as wide and as high as the face allows.
cross: two bars of the same relative width.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.messages import Body, Marking, MarkingKind
from surefetch.executor.simulation import scene_meshes
from surefetch.executor.simulation.scene_meshes import Mesh

PROUD_M = 0.0004
"""How far the patch stands off the surface, so that the renderer shows it whole."""
CELL_RAD = np.radians(7.5)
ROUND_HALF_SECTOR_RAD = np.pi / 4.0
HEXAGON_HALF_SECTOR_RAD = np.pi / 6.0
AZIMUTH_RAD = {"front": np.pi, "right": -np.pi / 2.0}


@dataclass(frozen=True, eq=False)
class UnrolledFace:
    """A face laid flat: outline (n, 2), cell edges along u and v, and the way back to 3-D."""

    outline: Array
    cuts_u: Array
    cuts_v: Array
    to_body_m: Callable[[Array], Array]
    """(n, 2) -> (n, 3)"""


def patch(body: Body, marking: Marking) -> Mesh | None:
    """The marking's mesh, a little proud of the body; None for a plain body."""
    if marking.kind == "plain":
        return None
    face = unroll(body, marking)
    pieces = cut_out(marking.kind, face.outline, marking.coverage)
    cells = [cell for piece in pieces for cell in _in_cells(piece, face)]
    return scene_meshes.merged([_fan(face.to_body_m(cell)) for cell in cells])


def unroll(body: Body, marking: Marking) -> UnrolledFace:
    """The marked face of a body, laid flat."""
    if body.shape == "ball":
        return _ball_top(body) if marking.face == "top" else _ball_side(body, marking)
    if marking.face == "top":
        return _flat_top(body)
    if body.shape in ("cube", "block"):
        return _flat_side(body, marking)
    return _wrapped_side(body, marking)


def cut_out(kind: MarkingKind, outline: Array, coverage: float) -> list[Array]:
    """Convex pieces (n, 2) of the marking that together cover this share of the outline's area."""
    wanted = coverage * area(outline)
    low, high = 0.0, 1.5
    for _ in range(40):
        middle = (low + high) / 2.0
        covered = sum(area(piece) for piece in _pieces(kind, outline, middle))
        low, high = (middle, high) if covered < wanted else (low, middle)
    return _pieces(kind, outline, high)


def area(polygon: Array) -> float:
    """Area of a simple polygon (n, 2), counter-clockwise positive."""
    if len(polygon) < 3:
        return 0.0
    x, y = polygon.T
    return float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))) / 2.0


def clip(polygon: Array, axis: int, bound: float, side: float) -> Array:
    """The part of a convex polygon with side * coordinate <= side * bound (Sutherland-Hodgman)."""
    if len(polygon) == 0:
        return polygon
    distance = side * (bound - polygon[:, axis])
    kept = []
    for k in range(len(polygon)):
        here, there = distance[k - 1], distance[k]
        if (here < 0.0) != (there < 0.0):
            kept.append(polygon[k - 1] + here / (here - there) * (polygon[k] - polygon[k - 1]))
        if there >= 0.0:
            kept.append(polygon[k])
    return np.array(kept).reshape(-1, 2)


def _between(polygon: Array, axis: int, low: float, high: float) -> Array:
    return clip(clip(polygon, axis, low, -1.0), axis, high, 1.0)


def _pieces(kind: MarkingKind, outline: Array, width: float) -> list[Array]:
    """The marking at a relative width of 0 (nothing) to 1 (as large as the outline)."""
    half_u, half_v = np.abs(outline).max(axis=0) * width
    if kind == "dot":
        angles = np.arange(48) * 2.0 * np.pi / 48.0
        ellipse = np.column_stack([half_u * np.cos(angles), half_v * np.sin(angles)])
        return [_inside(ellipse, outline)]
    bar = _between(outline, 1, -half_v, half_v)
    if kind == "stripe":
        return [bar]
    column = _between(outline, 0, -half_u, half_u)
    return [bar, clip(column, 1, half_v, -1.0), clip(column, 1, -half_v, 1.0)]


def _inside(polygon: Array, outline: Array) -> Array:
    """The part of a convex polygon inside a convex outline, both counter-clockwise."""
    for start, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        along = end - start
        into = np.array([-along[1], along[0]])
        turned = np.column_stack([polygon @ along, polygon @ into])
        if (turned[:, 1] >= start @ into).all():
            continue
        turned = clip(turned, 1, float(start @ into), -1.0)
        polygon = (turned @ np.array([along, into])) / (along @ along)
    return polygon


def _in_cells(piece: Array, face: UnrolledFace) -> list[Array]:
    """The piece cut along the face's cell edges, so that it can follow a curved surface."""
    cells = []
    for low_u, high_u in zip(face.cuts_u[:-1], face.cuts_u[1:], strict=True):
        strip = _between(piece, 0, low_u, high_u)
        for low_v, high_v in zip(face.cuts_v[:-1], face.cuts_v[1:], strict=True):
            cell = _between(strip, 1, low_v, high_v)
            if area(cell) > 1e-10:
                cells.append(cell)
    return cells


def _fan(vertices_m: Array) -> Mesh:
    k = np.arange(1, len(vertices_m) - 1)
    return Mesh(vertices_m, np.column_stack([np.zeros_like(k), k, k + 1]))


def _rectangle(half_u: float, half_v: float) -> Array:
    return np.array([[half_u, -half_v], [half_u, half_v], [-half_u, half_v], [-half_u, -half_v]])


def _flat(outline: Array, to_body_m: Callable[[Array], Array]) -> UnrolledFace:
    edge = np.array([-np.inf, np.inf])
    return UnrolledFace(outline, edge, edge, to_body_m)


def _flat_top(body: Body) -> UnrolledFace:
    z = body.size_m[2] / 2.0 + PROUD_M

    def to_body(uv: Array) -> Array:
        return np.column_stack([uv[:, 1], -uv[:, 0], np.full(len(uv), z)])

    footprint = scene_meshes.outline(body.shape, body.size_m)
    outline: Array = np.column_stack([-footprint[:, 1], footprint[:, 0]])
    return _flat(outline, to_body)


def _flat_side(body: Body, marking: Marking) -> UnrolledFace:
    x, y, z = body.size_m
    azimuth = AZIMUTH_RAD[marking.face]
    half_u, off = (y / 2.0, x / 2.0) if marking.face == "front" else (x / 2.0, y / 2.0)
    out = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    along = np.array([-out[1], out[0], 0.0])

    def to_body(uv: Array) -> Array:
        points: Array = (off + PROUD_M) * out + uv[:, :1] * along + uv[:, 1:] * [0.0, 0.0, 1.0]
        return points

    return _flat(_rectangle(half_u, z / 2.0), to_body)


def _wrapped_side(body: Body, marking: Marking) -> UnrolledFace:
    """A sector of an upright round or six-sided body; u is the azimuth, stretched to metres."""
    half = HEXAGON_HALF_SECTOR_RAD if body.shape == "hexagonal prism" else ROUND_HALF_SECTOR_RAD
    azimuth = AZIMUTH_RAD[marking.face]
    footprint = scene_meshes.outline(body.shape, body.size_m)
    radius = body.size_m[0] / 2.0

    def to_body(uv: Array) -> Array:
        angle = azimuth + uv[:, 0] / radius
        out = np.column_stack([np.cos(angle), np.sin(angle)])
        reach = _reach(footprint, out) + PROUD_M
        return np.column_stack([out * reach[:, None], uv[:, 1]])

    cuts = _cuts(half, footprint, azimuth) * radius
    return UnrolledFace(
        _rectangle(half * radius, body.size_m[2] / 2.0), cuts, np.array([-np.inf, np.inf]), to_body
    )


def _reach(footprint: Array, directions: Array) -> Array:
    """Distance (n,) from the origin to a convex outline's edge along directions (n, 2)."""
    along = np.roll(footprint, -1, axis=0) - footprint
    normals = np.column_stack([along[:, 1], -along[:, 0]])
    offsets = np.sum(normals * footprint, axis=1)
    distance: Array = 1.0 / np.max(directions @ (normals / offsets[:, None]).T, axis=1)
    return distance


def _cuts(half: float, footprint: Array, azimuth: float) -> Array:
    """Azimuths of the outline's corners within the sector, relative to its middle."""
    corners = np.arctan2(footprint[:, 1], footprint[:, 0]) - azimuth
    corners = np.arctan2(np.sin(corners), np.cos(corners))
    return np.array([-half, *np.sort(corners[np.abs(corners) < half - 1e-6]), half])


def _ball_side(body: Body, marking: Marking) -> UnrolledFace:
    radius, azimuth = body.size_m[0] / 2.0, AZIMUTH_RAD[marking.face]
    half = ROUND_HALF_SECTOR_RAD

    def to_body(uv: Array) -> Array:
        return _on_ball(body, azimuth + uv[:, 0] / radius, uv[:, 1] / radius)

    cuts = np.arange(-half, half + 1e-6, CELL_RAD) * radius
    return UnrolledFace(_rectangle(half * radius, half * radius), cuts, cuts, to_body)


def _ball_top(body: Body) -> UnrolledFace:
    radius, half = body.size_m[0] / 2.0, ROUND_HALF_SECTOR_RAD
    angles = np.arange(48) * 2.0 * np.pi / 48.0
    outline = half * radius * np.column_stack([np.cos(angles), np.sin(angles)])

    def to_body(uv: Array) -> Array:
        from_pole = np.hypot(uv[:, 0], uv[:, 1]) / radius
        return _on_ball(body, np.arctan2(-uv[:, 0], uv[:, 1]), np.pi / 2.0 - from_pole)

    cuts = np.arange(-half, half + 1e-6, CELL_RAD) * radius
    return UnrolledFace(outline, cuts, cuts, to_body)


def _on_ball(body: Body, azimuth: Array, latitude: Array) -> Array:
    radius = body.size_m[0] / 2.0
    level = np.cos(latitude)
    unit = np.column_stack([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(latitude)])
    up = scene_meshes.ball_center_m(body.size_m[0], body.size_m[2])
    return unit * (radius + PROUD_M) + [0.0, 0.0, up]
