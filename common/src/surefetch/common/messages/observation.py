"""From pixels to answers: what perception is asked and what it replies. World frame = base_link."""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from surefetch.common import arrays
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages.base import Message, Name, Text, Xyz
from surefetch.common.messages.frame import FrameId

CoverState = Literal["covered", "open", "unknown"]


class Vocabulary(Message, frozen=True):
    """What a perception back-end understands. Open: any phrase; else only the words listed."""

    backend: Name
    """Identity of the back-end; fitted parameters belong to one."""
    open: bool
    nouns: tuple[str, ...]
    """Nouns that name no shape ("object", "thing")."""
    colors: tuple[str, ...]
    shapes: tuple[str, ...]
    markings: tuple[str, ...]
    containers: tuple[str, ...]


class Target(Message, frozen=True):
    """The object meant. An absent attribute is not asked and counts as supported."""

    noun: Name
    color: str | None = None
    shape: str | None = None
    marking: str | None = None
    relation: AskedRelation = "any"
    container: str = "box"


class Observe(Message, frozen=True):
    """Perceive one frame with one target in mind."""

    episode: Name
    step: int
    frame: FrameId
    target: Target


class Mask(Message, frozen=True):
    """A binary image, run-length coded: column-major, background first (uncompressed COCO)."""

    height: int
    width: int
    counts: tuple[int, ...]


class Answer(Message, frozen=True):
    """One three-choice question, answered. Scores compare only within the question."""

    label: Name
    scores: tuple[float, float, float]
    """In the fixed order of the question's labels; the label is the first of the largest."""
    evidence: dict[str, float] = {}
    """Numbers behind the scores, for logs and figures only."""


class Answers(Message, frozen=True):
    """The four questions. None: not asked, counts as supported."""

    color: Answer | None
    shape: Answer | None
    marking: Answer | None
    membership: Answer


class Box3d(Message, frozen=True):
    """An upright box: centre and full sizes in its own axes, turned by yaw about world z."""

    center_world_m: Xyz
    size_m: Xyz
    yaw_rad: float


class Detection(Message, frozen=True, eq=False):
    """One candidate of one frame."""

    id: Name
    """Unique in the episode: frame boot, frame counter, index."""
    box_px: tuple[float, float, float, float]
    """x0, y0, x1, y1"""
    score: float
    phrase: str
    mask: Mask
    group: int
    representative: bool
    center_world_m: Xyz | None
    """Centre of the body, not of its visible surface. None: no usable depth, not tracked."""
    solid: Box3d | None
    """Extents, yaw and top of the body as far as seen; bottom is where it stands."""
    points_world_m: NDArray[np.float32]
    """(n, 3) visible surface, n at most 600, cleaned of outliers."""
    hist: tuple[float, ...] | None
    """14 bins that sum to 1, or None."""
    answers: Answers | None

    def __post_init__(self) -> None:
        arrays.check("points_world_m", self.points_world_m, np.float32, (None, 3))


class Lid(Message, frozen=True):
    """A cover on the container: the plate and where it can be taken."""

    plate: Box3d
    knob: Box3d | None


class ContainerReading(Message, frozen=True):
    """The reference container as seen."""

    box_px: tuple[float, float, float, float]
    score: float
    mask: Mask
    outer: Box3d
    """Outer walls, from the support to the rim."""
    inner_size_m: tuple[float, float]
    """Inner lengths along the outer box's own x and y."""
    floor_z_m: float
    rim_z_m: float
    complete: bool
    """False when the image border cuts it; memberships are then not trusted."""
    lid: Lid | None


class Observations(Message, frozen=True, eq=False):
    """Everything perception says of one frame."""

    frame: FrameId
    backend: Name
    detections: tuple[Detection, ...]
    container: ContainerReading | None
    cover: CoverState
    obstacles: tuple[Box3d, ...]
    """Bodies that are no candidate and no container: screens, walls, the unexplained."""
    obstacle_points_world_m: NDArray[np.float32]
    """(n, 3) thinned surface points of all above the support, for collision checks."""
    duration_s: float
    notes: Text = ""

    def __post_init__(self) -> None:
        arrays.check("obstacle_points_world_m", self.obstacle_points_world_m, np.float32, (None, 3))
