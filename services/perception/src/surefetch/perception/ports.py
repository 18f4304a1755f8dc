"""What a perception back-end is made of. Values in, values out; no bus, no clock.

The steps around these ports (`observe`) are the same for every back-end, so that a detector with
weights, a segmenter with weights and a language model fit where the classical ones stand.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from surefetch.common.mask import Bits
from surefetch.common.messages import Answers, Target, Vocabulary
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.perception.candidate import Candidate, SceneView

BoxPx = tuple[float, float, float, float]
"""x0, y0, x1, y1 in pixels, the far edges exclusive"""


@dataclass(frozen=True)
class Proposal:
    """A region that may show a thing."""

    box_px: BoxPx
    score: float
    """In [0, 1]; ranks the proposals of a frame"""
    phrase: str
    """What it was proposed as"""


@dataclass(frozen=True)
class Proposals:
    """What may be meant, best first, and the reference container."""

    candidates: tuple[Proposal, ...]
    container: Proposal | None


class Proposer(Protocol):
    """Finds where in the image to look closer."""

    def propose(self, frame: RgbdFrame, target: Target) -> Proposals:
        """Regions that may show the target or a rival of it, and the container in view."""
        ...


class Segmenter(Protocol):
    """Finds the pixels of what a box encloses."""

    def segment(self, frame: RgbdFrame, boxes: Sequence[BoxPx]) -> tuple[Bits, ...]:
        """A mask (h, w) for each box, in order; empty where it finds nothing."""
        ...


class Scorer(Protocol):
    """Answers the four questions about each candidate."""

    def score(
        self, scene: SceneView, candidates: Sequence[Candidate], target: Target
    ) -> tuple[Answers, ...]:
        """Answers to each candidate, in order. Attributes that the target lacks are not asked."""
        ...


@dataclass(frozen=True)
class Backend:
    """A way to perceive. Fitted parameters belong to one, by the name in its vocabulary."""

    vocabulary: Vocabulary
    proposer: Proposer
    segmenter: Segmenter
    scorer: Scorer

    @property
    def name(self) -> str:
        """Identity, as in messages and parameter files."""
        return self.vocabulary.backend
