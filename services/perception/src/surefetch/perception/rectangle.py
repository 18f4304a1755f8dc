"""Rectangles in a top-down grid: rims of containers and plates of lids. Pure.

A grid cell is occupied when its highest observed point has the height in question.
"""

from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array

CELL_M: Final = 0.004
MIN_SIDE_M: Final = 0.11
MAX_SIDE_M: Final = 0.40
MIN_FILLED: Final = 0.6
"""Share of a plate's area that is seen; things in front may hide some."""
_N_LINES: Final = 7
"""Candidate lines per direction."""
_YAWS: Final = np.deg2rad(np.arange(0.0, 90.0, 1.5))


@dataclass(frozen=True)
class Rectangle:
    """A rectangle in the plane of the support, by the edges in its own axes."""

    yaw_rad: float
    """Of the u axis; v is 90 degrees on."""
    u_m: tuple[float, float]
    v_m: tuple[float, float]
    coverage: float = 1.0
    """Share of the outline, or of the area of a plate, that was seen."""

    def own(self, xy_m: NDArray[np.floating]) -> Array:
        """Points (..., 2) in the rectangle's axes, its centre as origin."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        u = xy_m[..., 0] * c + xy_m[..., 1] * s - 0.5 * sum(self.u_m)
        v = xy_m[..., 1] * c - xy_m[..., 0] * s - 0.5 * sum(self.v_m)
        return np.stack([u, v], axis=-1)

    def inset(self, xy_m: NDArray[np.floating]) -> Array:
        """How far points (..., 2) lie within the outline; negative outside."""
        own = np.abs(self.own(xy_m))
        gap: Array = np.minimum(self.size_m[0] / 2 - own[..., 0], self.size_m[1] / 2 - own[..., 1])
        return gap

    def grown(self, by_m: float) -> "Rectangle":
        """Every side moved outwards."""
        (u0, u1), (v0, v1) = self.u_m, self.v_m
        return replace(self, u_m=(u0 - by_m, u1 + by_m), v_m=(v0 - by_m, v1 + by_m))

    @property
    def size_m(self) -> tuple[float, float]:
        """Full lengths along u and v."""
        return (self.u_m[1] - self.u_m[0], self.v_m[1] - self.v_m[0])

    @property
    def center_m(self) -> tuple[float, float]:
        """Where the middle is."""
        u, v = 0.5 * sum(self.u_m), 0.5 * sum(self.v_m)
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return (float(u * c - v * s), float(u * s + v * c))

    @property
    def area_m2(self) -> float:
        """Of the whole rectangle."""
        return self.size_m[0] * self.size_m[1]


def find_outline(cells_m: Array) -> Rectangle | None:
    """The rectangle whose four sides are best covered by occupied cells (n, 2).

    Works through peaks of the cells' projections, so that things inside, beside and sticking out
    do not matter.
    """
    if len(cells_m) < 60:
        return None
    best = None
    for yaw in _likely_yaws(cells_m):
        found = _best_at(cells_m, yaw)
        if found is not None and (best is None or found[0] > best[0]):
            best = found
    return best[1] if best else None


def _projected(cells_m: Array, yaw: Array | float) -> tuple[Array, Array]:
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = cells_m[:, 0], cells_m[:, 1]
    return np.multiply.outer(c, x) + np.multiply.outer(s, y), np.multiply.outer(
        c, y
    ) - np.multiply.outer(s, x)


def _likely_yaws(cells_m: Array) -> list[float]:
    """Turns at which the projections are most peaked: long straight walls line up."""
    u, v = _projected(cells_m, _YAWS)
    peaked = _peakedness(u) + _peakedness(v)
    first = int(np.argmax(peaked))
    fine = _YAWS[first] + np.deg2rad(np.array([-1.0, -0.5, 0.0, 0.5, 1.0]))
    u, v = _projected(cells_m, fine)
    return [float(fine[int(np.argmax(_peakedness(u) + _peakedness(v)))])]


def _peakedness(projections_m: Array) -> Array:
    rows = np.floor((projections_m - projections_m.min()) / CELL_M).astype(np.int64)
    width = int(rows.max()) + 1
    flat = rows + width * np.arange(len(rows))[:, None]
    counts = np.bincount(flat.ravel(), minlength=width * len(rows)).reshape(len(rows), width)
    return np.asarray((counts.astype(np.float64) ** 2).sum(1))


def _best_at(cells_m: Array, yaw: float) -> tuple[float, Rectangle] | None:
    u, v = _projected(cells_m, yaw)
    origin = np.array([u.min(), v.min()]) - 2 * CELL_M
    iu = np.floor((u - origin[0]) / CELL_M).astype(int)
    iv = np.floor((v - origin[1]) / CELL_M).astype(int)
    grid = np.zeros((iu.max() + 3, iv.max() + 3), dtype=np.uint8)
    grid[iu, iv] = 1
    thick = cv2.dilate(grid, np.ones((3, 3), np.uint8))
    along_v = np.pad(np.cumsum(thick, axis=1, dtype=np.int64), ((0, 0), (1, 0)))
    along_u = np.pad(np.cumsum(thick, axis=0, dtype=np.int64), ((1, 0), (0, 0)))
    pairs_u, pairs_v = _pairs(grid.sum(1)), _pairs(grid.sum(0))
    if not len(pairs_u) or not len(pairs_v):
        return None
    a, b = pairs_u[:, None, 0], pairs_u[:, None, 1]
    c, d = pairs_v[None, :, 0], pairs_v[None, :, 1]
    sides = np.stack(
        [
            (along_v[a, d + 1] - along_v[a, c]) / (d + 1 - c),
            (along_v[b, d + 1] - along_v[b, c]) / (d + 1 - c),
            (along_u[b + 1, c] - along_u[a, c]) / (b + 1 - a),
            (along_u[b + 1, d] - along_u[a, d]) / (b + 1 - a),
        ]
    )
    sides = np.sort(sides, axis=0)
    lengths = (b - a) + (d - c)
    score = np.where((sides[0] > 0.15) & (sides[1] > 0.4), sides.mean(0) + 0.001 * lengths, 0.0)
    at = np.unravel_index(int(np.argmax(score)), score.shape)
    if score[at] == 0.0:
        return None
    edges_u = origin[0] + (pairs_u[at[0]] + 0.5) * CELL_M
    edges_v = origin[1] + (pairs_v[at[1]] + 0.5) * CELL_M
    outline = Rectangle(
        yaw,
        (float(edges_u[0]), float(edges_u[1])),
        (float(edges_v[0]), float(edges_v[1])),
        float(sides[:, at[0], at[1]].mean()),
    )
    return float(score[at]), outline


def _pairs(counts: NDArray[np.integer]) -> NDArray[np.intp]:
    """(n, 2) pairs of the strongest lines, ascending, at a distance that fits a container."""
    smooth = np.convolve(counts, [0.5, 1.0, 0.5], mode="same")
    is_peak = (smooth >= np.roll(smooth, 1)) & (smooth >= np.roll(smooth, -1)) & (smooth > 4)
    peaks = np.flatnonzero(is_peak)
    peaks = np.sort(peaks[np.argsort(-smooth[peaks], kind="stable")[:_N_LINES]])
    a, b = np.triu_indices(len(peaks), 1)
    gap_m = (peaks[b] - peaks[a]) * CELL_M
    fits = (gap_m > MIN_SIDE_M) & (gap_m < MAX_SIDE_M)
    return np.column_stack([peaks[a][fits], peaks[b][fits]])


def find_plates(cells_m: Array) -> list[Rectangle]:
    """The filled rectangles of at least a lid's size that the occupied cells (n, 2) make."""
    if len(cells_m) < 0.4 * MIN_SIDE_M**2 / CELL_M**2:
        return []
    origin = cells_m.min(0) - 2 * CELL_M
    at = np.floor((cells_m - origin) / CELL_M).astype(int)
    grid = np.zeros(at.max(0) + 3, dtype=np.uint8)
    grid[at[:, 0], at[:, 1]] = 1
    opened = cv2.morphologyEx(grid, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    opened = cv2.morphologyEx(opened, cv2.MORPH_OPEN, np.ones((5, 5), np.uint8))
    n, labels, stats, _ = cv2.connectedComponentsWithStats(opened, connectivity=4)
    big = stats[:, cv2.CC_STAT_AREA] > 0.4 * MIN_SIDE_M**2 / CELL_M**2
    plates = [_plate(np.argwhere(labels == i), origin) for i in range(1, n) if big[i]]
    return [plate for plate in plates if plate is not None]


def _plate(ij: NDArray[np.intp], origin: Array) -> Rectangle | None:
    """The rectangle around the grid cells (n, 2), if they fill it and its size fits a lid."""
    corners = cv2.boxPoints(cv2.minAreaRect(ij.astype(np.float32)))
    edge = corners[1] - corners[0]
    yaw = float(np.arctan2(edge[1], edge[0]) % (np.pi / 2))
    u, v = _projected(origin + (ij + 0.5) * CELL_M, yaw)
    half = CELL_M / 2
    edges_u = (float(u.min() - half), float(u.max() + half))
    edges_v = (float(v.min() - half), float(v.max() + half))
    plate = Rectangle(yaw, edges_u, edges_v)
    filled = len(ij) * CELL_M**2 / plate.area_m2
    if min(plate.size_m) < MIN_SIDE_M or max(plate.size_m) > MAX_SIDE_M or filled < MIN_FILLED:
        return None
    return Rectangle(yaw, edges_u, edges_v, filled)
