"""What a candidate's pixels show, once, for all questions about it. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array
from surefetch.common.mask import Bits
from surefetch.perception.answers import boxes, faces, patches, patterns
from surefetch.perception.answers.faces import Bools, Surfaces
from surefetch.perception.answers.patterns import Explanation
from surefetch.perception.answers.see_through import Window, rays_of
from surefetch.perception.answers.tones import Tones, tones_of
from surefetch.perception.candidate import Candidate
from surefetch.perception.solids import Solid
from surefetch.perception.surface import Surface

MAX_PX: Final = 2500
MIN_PX: Final = 40
PARTLY_HIDDEN: Final = 0.03


@dataclass(frozen=True, eq=False)
class Look:
    """A candidate's pixels (n,) in two tones, and what marking explains them."""

    surface: Surface
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

    @cached_property
    def window(self) -> Window:
        """The image around the candidate."""
        return Window(self.surface, self.candidate.bits)


def look_at(surface: Surface, candidate: Candidate) -> Look:
    """Read a candidate's pixels."""
    rows, columns, share = _pixels(candidate.bits)
    tones = tones_of(surface.frame.rgb[rows, columns])
    look = Look(surface, candidate, tones, tones.other, {}, 0.0, share)
    solids = _solids(look)
    if not solids:
        return look
    rays = rays_of(surface, rows, columns)
    laid = [faces.lay(solid, rays, surface.eye_world_m) for solid in solids]
    px_m = _pixel_m(surface, solids[0])
    explained = _explained(laid, tones.other, share, px_m)
    if tones.colored:
        return replace(look, explanations=explained)
    return _cheaper(look, explained, _explained(laid, ~tones.other, share, px_m))


def best_solid(candidate: Candidate) -> Solid | None:
    """The solid that leaves the least residual."""
    fits = candidate.fits.values()
    return min(fits, key=lambda solid: solid.rms) if fits else None


def _solids(look: Look) -> list[Solid]:
    """The best solid, and those that it may be if part of it is hidden."""
    best = best_solid(look.candidate)
    if best is None:
        return []
    if best.kind == "box" and look.candidate.occluded_share > PARTLY_HIDDEN:
        return boxes.possible(look.window, best)
    return [best]


def _cheaper(
    look: Look, explained: dict[str, Explanation], swapped: dict[str, Explanation]
) -> Look:
    """Of a body without hue, the tone is the body's that leaves the likelier marking.

    Where all that is seen may be marking, nothing is known of the body's own tone.
    """
    cost = min(found.cost_px for found in explained.values())
    other_cost = min(found.cost_px for found in swapped.values())
    if other_cost < cost and look.marked.any():
        return replace(look, marked=~look.marked, explanations=swapped, rival_px=cost - other_cost)
    return replace(look, explanations=explained, rival_px=other_cost - cost)


def _explained(
    laid: Sequence[Surfaces], marked: Bools, share: float, px_m: float
) -> dict[str, Explanation]:
    """The best explanation of each kind over all solids."""
    best: dict[str, Explanation] = {}
    for surfaces in laid:
        weight = patterns.weights(surfaces, share)
        azimuth = _azimuth_of(surfaces, marked & surfaces.hit & ~surfaces.on_top)
        flat = patches.patches(surfaces, azimuth)
        for kind, found in patterns.explain(marked, weight, flat, px_m).items():
            if kind not in best or found.cost_px < best[kind].cost_px:
                best[kind] = found
    return best


def _azimuth_of(laid: Surfaces, marked: Bools) -> float | None:
    if np.count_nonzero(marked) < 8:
        return None
    azimuth = laid.azimuth_rad[marked]
    return float(np.arctan2(np.sin(azimuth).mean(), np.cos(azimuth).mean()))


def _pixels(bits: Bits) -> tuple[NDArray[np.intp], NDArray[np.intp], float]:
    """Rows and columns within the mask, thinned where there are many, and their share."""
    eroded = cv2.erode(bits.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
    rows, columns = np.nonzero(eroded if np.count_nonzero(eroded) >= MIN_PX else bits)
    step = max(1, -(-len(rows) // MAX_PX))
    return rows[::step], columns[::step], float(step)


def _pixel_m(surface: Surface, solid: Solid) -> float:
    """Width of a pixel on the body."""
    middle: Array = np.array([solid.x_m, solid.y_m, 0.5 * (solid.base_m + solid.top_m)])
    return float(np.linalg.norm(middle - surface.eye_world_m) / surface.frame.K[0, 0])
