"""The reference container: footprint, rim, floor, lid and whether it is covered. Geometry only.

A container is four walls of one height that close a rectangle, or a flat plate of such a size on
top of them. Colour plays no part, so that a box and an object of one colour separate. Pure.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.messages import Box3d, CoverState
from surefetch.perception.mask import Bits
from surefetch.perception.rectangle import CELL_M, Rectangle, find_outline, find_plates
from surefetch.perception.surface import Floats, Surface

LOWEST_RIM_M: Final = 0.016
HIGHEST_RIM_M: Final = 0.20
LEVEL_TOLERANCE_M: Final = 0.004
MIN_CELLS: Final = 45
"""Fewer columns of one height are no rim"""
PEAK_MM: Final = 2
MAX_LEVELS: Final = 8
MIN_COVERAGE: Final = 0.6
WALL_SLACK_M: Final = 0.005
"""Points this near to a wall belong to it."""
FLOOR_SLACK_M: Final = 0.005
DEFAULT_FLOOR_M: Final = 0.004
DEFAULT_WALL_M: Final = 0.006
DEFAULT_OVERHANG_M: Final = 0.008
MIN_OVERHANG_M: Final = 0.0035
MAX_OVERHANG_M: Final = 0.02
LID_THICKNESS_M: Final = 0.006
"""Walls and floor under a lid are not seen; these are usual."""
KNOB_M: Final = 0.008
"""Things higher than this on a lid are its knob."""
FRAME_PX: Final = 2


@dataclass(frozen=True, eq=False)
class Lid:
    """A plate on the rim; heights count from the support."""

    plate: Rectangle
    top_m: float
    knob: Box3d | None


@dataclass(frozen=True, eq=False)
class Container:
    """What a frame shows of the reference container; heights count from the support."""

    outer: Rectangle
    inner: Rectangle
    rim_m: float
    floor_m: float
    lid: Lid | None
    mask: Bits
    complete: bool
    """The image border does not cut it."""
    score: float
    """Share of its outline, or of its lid, that was seen."""

    @property
    def cover(self) -> CoverState:
        """Whether a lid is on."""
        return "covered" if self.lid else "open"

    def holds(self, xy_m: NDArray[np.floating]) -> NDArray[np.bool_]:
        """Which points (..., 2) are over the interior."""
        inside: NDArray[np.bool_] = self.inner.inset(xy_m) > 0
        return inside


def find(surface: Surface) -> Container | None:
    """The container in view, or None.

    A lid shows a knob, or sticks out over the walls; a wide body with a flat top does neither.
    """
    tall = surface.valid & (surface.height_m > LOWEST_RIM_M) & (surface.height_m < HIGHEST_RIM_M)
    points = surface.points_world_m[tall]
    heights = surface.height_m[tall]
    cells, tops = _columns(points[:, :2], heights)
    plates = [
        _measured(surface, points, heights, plate, level)
        for level, at_level in _by_level(cells, tops)
        for plate in find_plates(at_level)
    ]
    knobbed = [plate for plate in plates if plate.knob is not None]
    if knobbed:
        return _covered(surface, max(knobbed, key=lambda lid: lid.plate.coverage))
    overhanging = [plate for plate in plates if plate.sticks_out]
    others = _none_within([plate.plate for plate in plates if not plate.sticks_out], cells)
    rims = [
        (level, outline)
        for level, at_level in _by_level(cells[others], tops[others])
        if (outline := find_outline(at_level)) is not None and outline.coverage >= MIN_COVERAGE
    ]
    if rims:
        level, outline = max(rims, key=lambda rim: rim[1].coverage)
        return _open(surface, points, heights, outline, level)
    if overhanging:
        return _covered(surface, max(overhanging, key=lambda lid: lid.plate.coverage))
    return None


def _none_within(plates: list[Rectangle], cells: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which cells (n, 2) belong to none of the plates."""
    free = np.ones(len(cells), dtype=np.bool_)
    for plate in plates:
        free &= plate.inset(cells) < -2 * CELL_M
    return free


def _by_level(
    cells: NDArray[np.float64], tops: NDArray[np.float64]
) -> list[tuple[float, NDArray[np.float64]]]:
    """The commonest heights and the columns that end there."""
    return [(level, cells[np.abs(tops - level) < LEVEL_TOLERANCE_M]) for level in _levels(tops)]


def _columns(xy_m: Floats, heights: Floats) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres (n, 2) of the occupied cells from above, and the highest point in each (n,)."""
    if len(xy_m) == 0:
        return np.zeros((0, 2)), np.zeros(0)
    origin = xy_m.min(0)
    at = np.floor((xy_m - origin) / CELL_M).astype(np.int64)
    shape = at.max(0) + 1
    if shape[0] * shape[1] > 4_000_000:
        return np.zeros((0, 2)), np.zeros(0)
    tops = np.zeros(int(shape[0] * shape[1]))
    np.maximum.at(tops, at[:, 0] * shape[1] + at[:, 1], heights.astype(np.float64))
    used = np.flatnonzero(tops)
    cells = origin + (np.column_stack([used // shape[1], used % shape[1]]) + 0.5) * CELL_M
    return cells, tops[used]


def _levels(tops: NDArray[np.float64]) -> list[float]:
    """Heights at which many columns end, the commonest first."""
    counts = np.bincount(np.floor(tops / 0.001).astype(int), minlength=int(HIGHEST_RIM_M / 0.001))
    smooth = np.convolve(counts, np.ones(3), mode="same")
    peaks = [
        i
        for i in range(1, len(smooth) - 1)
        if smooth[i] >= MIN_CELLS
        and smooth[i] == smooth[max(0, i - PEAK_MM) : i + PEAK_MM + 1].max()
    ]
    peaks.sort(key=lambda i: -smooth[i])
    return [float((i + 0.5) * 0.001) for i in peaks[:MAX_LEVELS]]


def _open(
    surface: Surface, points: Floats, heights: Floats, outline: Rectangle, level: float
) -> Container:
    outer, inner, rim = _walls(points, heights, outline, level)
    floor = _floor(surface, inner, rim)
    mask = _wall_and_floor(surface, outer, inner, rim, floor)
    return Container(outer, inner, rim, floor, None, mask, _uncut(mask), outline.coverage)


@dataclass(frozen=True, eq=False)
class _Plate:
    """A flat level rectangle that may be a lid."""

    plate: Rectangle
    top_m: float
    knob: Box3d | None
    overhang_m: float | None
    """Over the walls below; None when too little of them is seen"""

    @property
    def sticks_out(self) -> bool:
        overhang_m = self.overhang_m
        return overhang_m is not None and overhang_m > MIN_OVERHANG_M and self.plate.coverage > 0.85


def _measured(
    surface: Surface, points: Floats, heights: Floats, plate: Rectangle, level: float
) -> _Plate:
    plate, top = _plate_edges(points, heights, plate, level)
    overhang = _overhang(points, heights, plate, top)
    return _Plate(plate, top, _knob(surface, plate, top), overhang)


def _covered(surface: Surface, lid: _Plate) -> Container:
    plate, top = lid.plate, lid.top_m
    overhang = DEFAULT_OVERHANG_M if lid.overhang_m is None else lid.overhang_m
    outer = _grown(plate, -float(np.clip(overhang, 0.0, MAX_OVERHANG_M)))
    inner = _grown(outer, -DEFAULT_WALL_M)
    inset = outer.inset(surface.points_world_m[..., :2])
    over = plate.inset(surface.points_world_m[..., :2])
    body = (inset > -WALL_SLACK_M) & (surface.height_m > 0.004)
    cap = (over > -WALL_SLACK_M) & (surface.height_m > top - 0.02)
    mask = surface.valid & (body | cap)
    return Container(
        outer=outer,
        inner=inner,
        rim_m=top - LID_THICKNESS_M,
        floor_m=DEFAULT_FLOOR_M,
        lid=Lid(plate, top, lid.knob),
        mask=mask,
        complete=_uncut(mask),
        score=min(1.0, plate.coverage),
    )


def _walls(
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
    return _grown(center, thick / 2), _grown(center, -thick / 2), rim


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


def _grown(rectangle: Rectangle, by_m: float) -> Rectangle:
    (u0, u1), (v0, v1) = rectangle.u_m, rectangle.v_m
    return replace(rectangle, u_m=(u0 - by_m, u1 + by_m), v_m=(v0 - by_m, v1 + by_m))


def _floor(surface: Surface, inner: Rectangle, rim: float) -> float:
    inset = inner.inset(surface.points_world_m[..., :2])
    inside = surface.valid & (inset > 0.012) & (surface.height_m < min(0.6 * rim, 0.02))
    heights = surface.height_m[inside]
    return float(np.median(heights)) if len(heights) > 50 else DEFAULT_FLOOR_M


def _wall_and_floor(
    surface: Surface, outer: Rectangle, inner: Rectangle, rim: float, floor: float
) -> Bits:
    xy = surface.points_world_m[..., :2]
    from_outside, from_inside = outer.inset(xy), inner.inset(xy)
    wall = (from_outside > -WALL_SLACK_M) & (from_inside < WALL_SLACK_M)
    wall &= (surface.height_m < rim + WALL_SLACK_M) & (surface.height_m > 0.003)
    ground = (from_inside > 0) & (surface.height_m < floor + FLOOR_SLACK_M)
    return np.asarray(surface.valid & (wall | ground))


def _plate_edges(
    points: Floats, heights: Floats, plate: Rectangle, level: float
) -> tuple[Rectangle, float]:
    near = (np.abs(heights - level) < LEVEL_TOLERANCE_M) & (plate.inset(points[:, :2]) > -0.008)
    top = float(np.median(heights[near])) if near.sum() > 50 else level
    c, s = np.cos(plate.yaw_rad), np.sin(plate.yaw_rad)
    x, y = points[near, 0].astype(np.float64), points[near, 1].astype(np.float64)
    u, v = x * c + y * s, y * c - x * s
    return replace(plate, u_m=_ends(u, v, plate.u_m), v_m=_ends(v, u, plate.v_m)), top


def _ends(
    across: NDArray[np.float64], along: NDArray[np.float64], guess: tuple[float, float]
) -> tuple[float, float]:
    """Where most rows of a plate begin and end; what touches it in a few does not count."""
    rows = np.floor((along - along.min()) / CELL_M).astype(int) if len(along) else along.astype(int)
    counts = np.bincount(rows)
    full = counts >= max(5, 0.3 * float(np.median(counts[counts > 0]))) if len(counts) else counts
    if np.count_nonzero(full) < 5:
        return guess
    first, last = np.full(len(counts), np.inf), np.full(len(counts), -np.inf)
    np.minimum.at(first, rows, across)
    np.maximum.at(last, rows, across)
    return float(np.median(first[full])), float(np.median(last[full]))


def _overhang(points: Floats, heights: Floats, plate: Rectangle, top: float) -> float | None:
    """How far the plate sticks out over the walls, from the walls seen below it."""
    below = (heights < top - 0.012) & (heights > 0.01)
    inset = plate.inset(points[:, :2])
    wall = inset[below & (inset > -0.01) & (inset < 0.03)]
    return float(np.median(wall)) if len(wall) > 100 else None


def _knob(surface: Surface, plate: Rectangle, top: float) -> Box3d | None:
    on_top = surface.valid & (surface.height_m > top + KNOB_M)
    on_top &= surface.height_m < top + 0.08
    on_top &= plate.inset(surface.points_world_m[..., :2]) > 0.01
    if on_top.sum() < 20:
        return None
    points = surface.points_world_m[on_top]
    own = plate.own(points[:, :2])
    low, high = np.percentile(own, 2, axis=0), np.percentile(own, 98, axis=0)
    middle, size = 0.5 * (low + high), high - low
    c, s = np.cos(plate.yaw_rad), np.sin(plate.yaw_rad)
    x = plate.center_m[0] + middle[0] * c - middle[1] * s
    y = plate.center_m[1] + middle[0] * s + middle[1] * c
    z_low, z_high = surface.support_z_m + top, float(np.percentile(points[:, 2], 97))
    return Box3d(
        center_world_m=(float(x), float(y), 0.5 * (z_low + z_high)),
        size_m=(float(size[0]), float(size[1]), z_high - z_low),
        yaw_rad=plate.yaw_rad,
    )


def _uncut(mask: Bits) -> bool:
    inner = mask[FRAME_PX:-FRAME_PX, FRAME_PX:-FRAME_PX]
    return int(np.count_nonzero(mask)) == int(np.count_nonzero(inner))
