"""The back-end without weights: bodies by depth, ranked by size and by the asked colour."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.mask import Bits, box_iou, box_of
from surefetch.common.messages import Target, Vocabulary
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.perception import bodies, likeness, screens
from surefetch.perception.answers.scorer import ClassicalScorer
from surefetch.perception.frame_geometry import Geometry, LatestGeometry
from surefetch.perception.lifting import Lifted
from surefetch.perception.ports import Backend, BoxPx, Proposal, Proposals

VOCABULARY: Final = Vocabulary(
    backend="classical-1",
    open=False,
    nouns=("object", "thing", "item"),
    colors=("red", "orange", "yellow", "green", "blue", "purple", "white", "black"),
    shapes=("cube", "block", "cylinder", "ball", "hexagonal prism"),
    markings=("plain", "stripe", "dot", "cross"),
    containers=("box", "container", "bin", "tray", "crate"),
)
SAME_BOX_IOU: Final = 0.5
SMALL_PX: Final = 20.0
"""Bodies of so few pixels may be nothing"""
SHAPE_PX: Final = 200.0
"""Bodies of so few pixels show little of their shape"""


def classical_backend(geometry: LatestGeometry) -> Backend:
    """Proposer and segmenter that share one analysis of each frame, and the scorer."""
    parts = LatestParts(geometry)
    return Backend(
        VOCABULARY, ClassicalProposer(geometry, parts), ClassicalSegmenter(parts), ClassicalScorer()
    )


@dataclass(frozen=True, eq=False)
class Parts:
    """Everything above the ground in one frame, by its visible pixels."""

    bodies: tuple[Bits, ...]
    screens: tuple[Bits, ...]
    container: Bits | None


def parts_of(geometry: Geometry) -> Parts:
    """Take a frame apart."""
    surface, container = geometry.surface, geometry.container
    found = bodies.find(surface, geometry.foreground)
    is_screen = [screens.is_screen(surface, container, bits) for bits in found]
    taken = np.any(found, axis=0) if found else np.zeros(surface.valid.shape, dtype=np.bool_)
    return Parts(
        tuple(bits for bits, screen in zip(found, is_screen, strict=True) if not screen),
        tuple(bits for bits, screen in zip(found, is_screen, strict=True) if screen),
        None if container is None else np.asarray(container.mask & ~taken),
    )


class LatestParts:
    """Keeps the parts of the frame asked about last, by the frame's identity."""

    def __init__(self, geometry: LatestGeometry) -> None:
        self._geometry = geometry
        self._latest: tuple[RgbdFrame, Parts] | None = None

    def of(self, frame: RgbdFrame) -> Parts:
        """As `parts_of`, worked out once for one frame."""
        if self._latest is None or self._latest[0] is not frame:
            self._latest = (frame, parts_of(self._geometry.of(frame)))
        return self._latest[1]


class ClassicalProposer:
    """Every body that stands on the support or in the container, the likeliest first."""

    def __init__(self, geometry: LatestGeometry, parts: LatestParts) -> None:
        self._geometry = geometry
        self._parts = parts

    def propose(self, frame: RgbdFrame, target: Target) -> Proposals:
        """See `ports.Proposer`."""
        parts = self._parts.of(frame)
        lifted = self._geometry.lifted(frame, parts.bodies)
        phrase = " ".join(word for word in (target.color, target.noun) if word)
        candidates = [
            Proposal(box_of(bits), _score(frame, bits, body, target), phrase)
            for bits, body in zip(parts.bodies, lifted, strict=True)
        ]
        candidates.sort(key=lambda proposal: -proposal.score)
        container = self._geometry.of(frame).container
        if container is None or parts.container is None:
            return Proposals(tuple(candidates), None)
        score = container.score
        found = Proposal(box_of(parts.container), score, target.container)
        return Proposals(tuple(candidates), found)


def _score(frame: RgbdFrame, bits: Bits, body: Lifted, target: Target) -> float:
    """What shows something, and looks like what is asked as far as it is seen, comes first."""
    n_px = int(np.count_nonzero(bits))
    color = likeness.of_color(frame.rgb[bits], target.color)
    build = likeness.of_build(body, target.shape)
    hidden = min(1.0, 2.0 * body.outline.occluded_share)
    trusted = (1.0 - hidden) * n_px / (n_px + SHAPE_PX)
    return n_px / (n_px + SMALL_PX) * (0.4 + 0.3 * color + 0.3 * (1.0 - trusted * (1.0 - build)))


class ClassicalSegmenter:
    """The body, or the container, whose box is the asked one."""

    def __init__(self, parts: LatestParts) -> None:
        self._parts = parts

    def segment(self, frame: RgbdFrame, boxes: Sequence[BoxPx]) -> tuple[Bits, ...]:
        """See `ports.Segmenter`."""
        parts = self._parts.of(frame)
        masks = [*parts.bodies, *([] if parts.container is None else [parts.container])]
        return tuple(_of_box(box, masks, frame) for box in boxes)


def _of_box(box: BoxPx, masks: Sequence[Bits], frame: RgbdFrame) -> Bits:
    overlaps = [box_iou(box, box_of(mask)) for mask in masks]
    best = int(np.argmax(overlaps)) if overlaps else -1
    if best < 0 or overlaps[best] < SAME_BOX_IOU:
        return np.zeros(frame.rgb.shape[:2], dtype=np.bool_)
    return masks[best]
