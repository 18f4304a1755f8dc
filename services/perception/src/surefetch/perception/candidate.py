"""What one frame shows, lifted to 3-D, as the questions are asked about it. Values only."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from surefetch.common.geometry import Array
from surefetch.common.mask import Bits
from surefetch.common.messages import Box3d
from surefetch.perception.container import Container
from surefetch.perception.solids import Kind, Solid
from surefetch.perception.surface import Floats, Surface


@dataclass(frozen=True, eq=False)
class Candidate:
    """One body that may be meant. Masks are (h, w) of the frame; heights are world z.

    Without usable depth there is no centre, no solid and no fit, but the mask may still tell the
    colour.
    """

    box_px: tuple[float, float, float, float]
    score: float
    phrase: str
    bits: Bits
    """(h, w) visible pixels"""
    core: Bits
    """(h, w) `bits` without a margin of 2 px; all of `bits` where little would remain"""
    n_px: int
    """Pixels of `bits`"""
    occluded_share: float
    """Share of the ring around the mask that something nearer than the body covers"""
    border_share: float
    """Share of the mask's outline that lies on the border of the image"""
    on_container_floor: bool
    """It stands on the floor of the container, not on the support"""
    base_m: float
    """World z of what it stands on"""
    center_world_m: tuple[float, float, float] | None
    """Of the body, not of its visible surface"""
    solid: Box3d | None
    """Extents of the body as far as seen, from `base_m` to its top"""
    fits: Mapping[Kind, Solid] = field(default_factory=dict)
    """The best upright solid of each kind, with the residual it leaves"""
    points_world_m: Floats | None = None
    """(n, 3) visible surface, n at most 600, without outliers"""
    hist: tuple[float, ...] | None = None
    """14 bins that sum to 1"""


@dataclass(frozen=True, eq=False)
class SceneView:
    """One frame as understood before any question is asked."""

    surface: Surface
    container: Container | None
    container_bits: Bits | None
    """The container's visible pixels by the segmenter"""
    candidates: tuple[Candidate, ...]
    """Best score first"""

    @property
    def eye_world_m(self) -> Array:
        """(3,) where the camera is."""
        return self.surface.eye_world_m
