"""The reference container: footprint, rim, floor, lid and whether it is covered. Geometry only.

A container is four walls of one height that close a rectangle, or a flat plate of such a size on
top of them. Colour plays no part, so that a box and an object of one colour separate. Pure.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.mask import Bits
from surefetch.common.messages import Box3d, CoverState
from surefetch.perception.lid import Plate, measured
from surefetch.perception.rectangle import CELL_M, Rectangle, find_outline, find_plates
from surefetch.perception.rim import DEFAULT_FLOOR_M, LEVEL_TOLERANCE_M, floor_height, walls
from surefetch.perception.surface import Floats, Surface

LOWEST_RIM_M: Final = 0.016
HIGHEST_RIM_M: Final = 0.20
MIN_CELLS: Final = 45
"""Fewer columns of one height are no rim"""
PEAK_MM: Final = 2
MAX_LEVELS: Final = 8
MIN_COVERAGE: Final = 0.6
WALL_SLACK_M: Final = 0.005
"""Points this near to a wall belong to it."""
FLOOR_SLACK_M: Final = 0.005
DEFAULT_WALL_M: Final = 0.006
DEFAULT_OVERHANG_M: Final = 0.008
MAX_OVERHANG_M: Final = 0.02
LID_THICKNESS_M: Final = 0.006
"""Walls and floor under a lid are not seen; these are usual."""
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
        measured(surface, points, heights, plate, level)
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
    outer, inner, rim = walls(points, heights, outline, level)
    floor = floor_height(surface, inner, rim)
    mask = _wall_and_floor(surface, outer, inner, rim, floor)
    return Container(outer, inner, rim, floor, None, mask, _uncut(mask), outline.coverage)


def _covered(surface: Surface, lid: Plate) -> Container:
    plate, top = lid.plate, lid.top_m
    overhang = DEFAULT_OVERHANG_M if lid.overhang_m is None else lid.overhang_m
    outer = plate.grown(-float(np.clip(overhang, 0.0, MAX_OVERHANG_M)))
    inner = outer.grown(-DEFAULT_WALL_M)
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


def _wall_and_floor(
    surface: Surface, outer: Rectangle, inner: Rectangle, rim: float, floor: float
) -> Bits:
    xy = surface.points_world_m[..., :2]
    from_outside, from_inside = outer.inset(xy), inner.inset(xy)
    wall = (from_outside > -WALL_SLACK_M) & (from_inside < WALL_SLACK_M)
    wall &= (surface.height_m < rim + WALL_SLACK_M) & (surface.height_m > 0.003)
    ground = (from_inside > 0) & (surface.height_m < floor + FLOOR_SLACK_M)
    return np.asarray(surface.valid & (wall | ground))


def _uncut(mask: Bits) -> bool:
    inner = mask[FRAME_PX:-FRAME_PX, FRAME_PX:-FRAME_PX]
    return int(np.count_nonzero(mask)) == int(np.count_nonzero(inner))
