"""What a candidate's pixels show, once, for all questions about it. Pure."""

from dataclasses import dataclass, replace
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.perception.answers import faces, patches, patterns
from surefetch.perception.answers.faces import Bools, Surfaces
from surefetch.perception.answers.patterns import Explanation
from surefetch.perception.answers.tones import Tones, tones_of
from surefetch.perception.candidate import Candidate
from surefetch.perception.solids import Kind, Solid
from surefetch.perception.surface import Surface

MAX_PX: Final = 2500
MIN_PX: Final = 40


@dataclass(frozen=True, eq=False)
class Look:
    """A candidate's pixels (n,): tones, and where they lie on the solid that fits best."""

    candidate: Candidate
    tones: Tones
    marked: Bools
    """(n,) the marking's tone; all else is the body's"""
    explanations: dict[str, Explanation]
    """Of `marked`, by kind of marking; empty without a solid"""
    rival_px: float
    """How much worse the other tone would do as the body's; 0 when they can't be told apart"""
    share: float
    """Pixels of the candidate that one used pixel stands for"""

    @property
    def n_marked_px(self) -> float:
        """Pixels of the candidate in the marking's tone."""
        return float(np.count_nonzero(self.marked)) * self.share


def look_at(surface: Surface, candidate: Candidate) -> Look:
    """Read a candidate's pixels."""
    rows, columns = _pixels(candidate)
    tones = tones_of(surface.frame.rgb[rows, columns])
    share = max(1.0, float(np.count_nonzero(_inner(candidate.bits))) / len(rows))
    plain = Look(candidate, tones, tones.other, {}, 0.0, share)
    solid = best_solid(candidate)
    if solid is None:
        return plain
    rays = _rays(surface, rows, columns)
    laid = faces.lay(solid, rays, surface.eye_world_m)
    px_m = _pixel_m(surface, solid)
    explained = _explained(laid, tones.other, share, px_m)
    if tones.colored or not tones.other.any():
        return replace(plain, explanations=explained)
    return _cheaper(plain, explained, _explained(laid, ~tones.other, share, px_m))


def best_solid(candidate: Candidate) -> Solid | None:
    """The solid that leaves the least residual."""
    fits = candidate.fits.values()
    return min(fits, key=lambda solid: solid.rms) if fits else None


def rms_of(candidate: Candidate) -> dict[Kind, float]:
    """Residual of each kind of solid, in standard deviations."""
    return {kind: solid.rms for kind, solid in candidate.fits.items()}


def _cheaper(
    plain: Look, explained: dict[str, Explanation], swapped: dict[str, Explanation]
) -> Look:
    """Of a body without hue, the tone is the body's that leaves the likelier marking."""
    cost = min(found.cost_px for found in explained.values())
    other_cost = min(found.cost_px for found in swapped.values())
    if other_cost < cost:
        return replace(
            plain, marked=~plain.marked, explanations=swapped, rival_px=cost - other_cost
        )
    return replace(plain, explanations=explained, rival_px=other_cost - cost)


def _explained(laid: Surfaces, marked: Bools, share: float, px_m: float) -> dict[str, Explanation]:
    weight = np.where(laid.hit, share, 0.0)
    azimuth = _azimuth_of(laid, marked & laid.hit & ~laid.on_top)
    return patterns.explain(marked, weight, patches.patches(laid, azimuth), px_m)


def _azimuth_of(laid: Surfaces, marked: Bools) -> float | None:
    if np.count_nonzero(marked) < 8:
        return None
    azimuth = laid.azimuth_rad[marked]
    return float(np.arctan2(np.sin(azimuth).mean(), np.cos(azimuth).mean()))


def _inner(bits: NDArray[np.bool_]) -> NDArray[np.bool_]:
    eroded = cv2.erode(bits.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
    return eroded if np.count_nonzero(eroded) >= MIN_PX else bits


def _pixels(candidate: Candidate) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    rows, columns = np.nonzero(_inner(candidate.bits))
    step = max(1, -(-len(rows) // MAX_PX))
    return rows[::step], columns[::step]


def _rays(surface: Surface, rows: NDArray[np.intp], columns: NDArray[np.intp]) -> Array:
    K = surface.frame.K
    camera = np.column_stack(
        [(columns - K[0, 2]) / K[0, 0], (rows - K[1, 2]) / K[1, 1], np.ones(len(rows))]
    )
    rays: Array = camera @ surface.T_world_camera[:3, :3].T
    return rays


def _pixel_m(surface: Surface, solid: Solid) -> float:
    middle = np.array([solid.x_m, solid.y_m, 0.5 * (solid.base_m + solid.top_m)])
    return float(np.linalg.norm(middle - surface.eye_world_m) / surface.frame.K[0, 0])
