"""From a mask to a body in the world: centre, extents, fits, appearance. Pure.

Only mask, colour and depth are used, so that a mask of any origin can be lifted.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse, project, transform
from surefetch.common.mask import Bits, box_of
from surefetch.common.messages import Box3d
from surefetch.perception import solids
from surefetch.perception.candidate import Candidate
from surefetch.perception.container import Container
from surefetch.perception.histogram import histogram
from surefetch.perception.outline import Outline, outline_of
from surefetch.perception.ports import Proposal
from surefetch.perception.solids import Kind, Seen, Solid, View
from surefetch.perception.surface import Floats, Surface

CORE_MIN_PX: Final = 40
MIN_DEPTH_PX: Final = 60
"""Fewer pixels with depth give no centre."""
MAX_POINTS: Final = 600
OUTLIER_M: Final = 0.010
GUARD_M: Final = 0.020
"""A fit farther than this from the push-back is not believed."""
MAX_WIDTH_M: Final = 0.25
MIN_WIDTH_M: Final = 0.012
MIN_HEIGHT_M: Final = 0.004
WELL_FITTED: Final = 1.0
"""Residual, in standard deviations, of a fit that may be believed against the push-back"""
MAX_SEEN_THROUGH: Final = 0.08
BEHIND_M: Final = 0.010
INSIDE: Final = 0.85
"""Points are taken this much nearer to the middle than the surface"""
_GRID: Final = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 7)] * 3), axis=-1).reshape(-1, 3)


@dataclass(frozen=True, eq=False)
class Lifted:
    """What one mask shows in the world."""

    core: Bits
    """(h, w) the mask without its margin"""
    outline: Outline
    inside: bool
    """Over the interior of an open container"""
    base_m: float
    """World z of what it stands on"""
    points_m: Floats
    """(n, 3) all usable surface points"""
    fits: Mapping[Kind, Solid]
    solid: Box3d | None
    """The body as a box; None without usable depth"""
    hist: tuple[float, ...] | None


def lift(
    surface: Surface, container: Container | None, masks: Sequence[Bits]
) -> tuple[Lifted, ...]:
    """Every mask (h, w) as a body, in order; all are fitted as one batch."""
    looks = [_look(surface, container, bits) for bits in masks]
    view = View(surface.frame.K, inverse(surface.T_world_camera), surface.eye_world_m)
    fitted = iter(solids.fit([look.seen for look in looks if look.seen is not None], view))
    return tuple(
        _lifted(surface, look, {} if look.seen is None else next(fitted)) for look in looks
    )


def candidate_of(proposal: Proposal, bits: Bits, lifted: Lifted) -> Candidate:
    """A proposal with its mask and what that shows."""
    n = len(lifted.points_m)
    return Candidate(
        box_px=box_of(bits),
        score=proposal.score,
        phrase=proposal.phrase,
        bits=bits,
        core=lifted.core,
        n_px=int(np.count_nonzero(bits)),
        occluded_share=lifted.outline.occluded_share,
        border_share=lifted.outline.border_share,
        on_container_floor=lifted.inside,
        base_m=lifted.base_m,
        center_world_m=None if lifted.solid is None else lifted.solid.center_world_m,
        solid=lifted.solid,
        fits=lifted.fits,
        points_world_m=lifted.points_m[_evenly(n, min(n, MAX_POINTS))],
        hist=lifted.hist,
    )


def _lifted(surface: Surface, look: "_Look", fits: dict[Kind, Solid]) -> Lifted:
    return Lifted(
        core=look.core,
        outline=look.outline,
        inside=look.inside,
        base_m=look.base_m,
        points_m=look.points_m,
        fits=fits,
        solid=None if look.pushed is None else guarded(fits, look.pushed, surface),
        hist=histogram(surface.frame.rgb[look.core]),
    )


@dataclass(frozen=True, eq=False)
class _Look:
    """What a mask shows before anything is fitted; without usable depth, no `pushed` and `seen`."""

    core: Bits
    outline: Outline
    inside: bool
    base_m: float
    points_m: Floats
    pushed: Box3d | None
    seen: Seen | None


def _look(surface: Surface, container: Container | None, bits: Bits) -> _Look:
    core = core_of(bits)
    points = _usable_points(surface, core)
    inside = _is_inside(container, points)
    floor_m = container.floor_m if container is not None and inside else 0.0
    base = surface.support_z_m + floor_m
    outline = outline_of(surface, base, bits)
    if len(points) < MIN_DEPTH_PX:
        return _Look(core, outline, inside, base, points, None, None)
    pushed = push_back(points, surface.eye_world_m, base)
    seen = _seen(surface, points, outline, pushed, base)
    return _Look(core, outline, inside, base, points, pushed, seen)


def _is_inside(container: Container | None, points: Floats) -> bool:
    """Most of the visible surface is over the interior of an open container."""
    if container is None or container.lid is not None or not len(points):
        return False
    return float(np.mean(container.inner.inset(points[:, :2]) > 0)) > 0.5


def core_of(bits: Bits) -> Bits:
    """The mask without a margin of 2 px, or all of it where little would remain."""
    core = cv2.erode(bits.astype(np.uint8), np.ones((3, 3), np.uint8), iterations=2) > 0
    return np.asarray(core if np.count_nonzero(core) >= CORE_MIN_PX else bits)


def _usable_points(surface: Surface, core: Bits) -> Floats:
    """(n, 3) of the core, without depths that do not belong to the rest."""
    rows, columns = np.nonzero(core & surface.valid)
    if not len(rows):
        return np.zeros((0, 3), dtype=np.float32)
    depth = surface.depth_m[rows, columns]
    off = np.abs(depth - np.median(depth))
    usable = off <= max(3 * 1.4826 * float(np.median(off)), OUTLIER_M)
    points: Floats = surface.points_world_m[rows[usable], columns[usable]]
    return points


def push_back(points_m: Floats, eye_m: Array, base_m: float) -> Box3d:
    """The upright body behind a visible surface (n, 3), taken to be as deep as it is wide."""
    points = points_m.astype(np.float64)
    away = points[:, :2].mean(0) - eye_m[:2]
    along = away / max(float(np.linalg.norm(away)), 1e-9)
    across = np.array([-along[1], along[0]])
    a = np.percentile(points[:, :2] @ along, (3, 97))
    b = np.percentile(points[:, :2] @ across, (3, 97))
    width = float(np.clip(b[1] - b[0], MIN_WIDTH_M, MAX_WIDTH_M))
    depth = max(width, float(a[1] - a[0]))
    middle = along * (a[0] + depth / 2) + across * 0.5 * (b[0] + b[1])
    top = max(float(np.percentile(points[:, 2], 98)), base_m + 0.004)
    return Box3d(
        center_world_m=(float(middle[0]), float(middle[1]), 0.5 * (base_m + top)),
        size_m=(depth, width, top - base_m),
        yaw_rad=float(np.arctan2(along[1], along[0])),
    )


def _seen(surface: Surface, points: Floats, outline: Outline, pushed: Box3d, base: float) -> Seen:
    picked = points[_evenly(len(points), solids.N_POINTS)].astype(np.float64)
    distance = np.linalg.norm(picked - surface.eye_world_m, axis=1)
    n = min(len(outline.samples_px), solids.N_OUTLINE)
    samples = np.zeros((solids.N_OUTLINE, 2))
    samples[:n] = outline.samples_px[_evenly(len(outline.samples_px), n)]
    x, y, _ = pushed.center_world_m
    return Seen(
        points_m=picked,
        sigma_m=0.0005 + 0.001 * (distance / 0.6) ** 2,
        outline_px=samples,
        outline_weight=(np.arange(solids.N_OUTLINE) < n).astype(np.float64),
        base_m=base,
        center_m=np.array([x, y]),
        width_m=pushed.size_m[1],
        top_m=base + pushed.size_m[2],
        yaw_rad=pushed.yaw_rad,
    )


def _evenly(n: int, wanted: int) -> NDArray[np.intp]:
    """`wanted` indices spread over n, repeated when there are fewer."""
    return np.asarray((np.arange(wanted) + 0.5) * n / max(wanted, 1)).astype(np.intp)


def guarded(fits: Mapping[Kind, Solid], pushed: Box3d, surface: Surface) -> Box3d:
    """The best fit as a box, if it can be; else the push-back.

    A few fits are far off; none may carry a centre away. A fit can be when it agrees with the
    push-back, or explains what is seen and is nowhere seen through: of a body that is mostly
    hidden, the push-back knows only the visible part.
    """
    for solid in sorted(fits.values(), key=lambda solid: solid.rms):
        x, y, _ = pushed.center_world_m
        height = solid.top_m - solid.base_m
        sound = min(solid.size_m) > MIN_WIDTH_M and max(solid.size_m) < MAX_WIDTH_M
        if not sound or height < MIN_HEIGHT_M:
            continue
        near = np.hypot(solid.x_m - x, solid.y_m - y) < GUARD_M
        if near or (solid.rms < WELL_FITTED and seen_through(solid, surface) < MAX_SEEN_THROUGH):
            return Box3d(
                center_world_m=(solid.x_m, solid.y_m, solid.base_m + height / 2),
                size_m=(*solid.size_m, height),
                yaw_rad=solid.yaw_rad,
            )
    return pushed


def seen_through(solid: Solid, surface: Surface) -> float:
    """Share of a solid's inside, as far as it is in the image, behind which something is seen."""
    half = np.array([*solid.size_m, solid.top_m - solid.base_m]) / 2
    c, s = np.cos(solid.yaw_rad), np.sin(solid.yaw_rad)
    own = _inside(solid.kind) * half * INSIDE
    x, y = own[:, 0] * c - own[:, 1] * s + solid.x_m, own[:, 0] * s + own[:, 1] * c + solid.y_m
    points = np.column_stack([x, y, own[:, 2] + 0.5 * (solid.base_m + solid.top_m)])
    in_camera = transform(inverse(surface.T_world_camera), points)
    at = np.rint(project(surface.frame.K, in_camera)).astype(int)
    h, w = surface.depth_m.shape
    shown = (at >= 0).all(1) & (at[:, 0] < w) & (at[:, 1] < h)
    depth = surface.depth_m[at[shown, 1], at[shown, 0]]
    behind = depth > in_camera[shown, 2] + BEHIND_M
    return float(np.mean(behind)) if len(behind) else 1.0


def _inside(kind: Kind) -> Array:
    """Points (n, 3) inside a solid whose half sizes are 1."""
    if kind == "box":
        return _GRID
    reach = np.linalg.norm(_GRID if kind == "ball" else _GRID[:, :2], axis=1)
    points: Array = _GRID[reach <= 1.0]
    return points
