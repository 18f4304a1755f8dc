"""From answers to a belief: what the belief service is told and what it replies."""

import numpy as np
from numpy.typing import NDArray

from surefetch.common import arrays
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages.base import Message, Name, Threshold, Xyz
from surefetch.common.messages.observation import Box3d, Detection


class Update(Message, frozen=True, eq=False):
    """One step of evidence. Step 0 of an episode starts a fresh belief."""

    episode: Name
    step: int
    obs_seq: int
    """Position of this observation in the episode, from 0, without gaps."""
    profile: Name
    """Which fitted parameters: `paper` or `extended`."""
    backend: Name
    q: Name
    """Viewing condition."""
    asked: AskedRelation
    """How the target stands, as far as the instruction says."""
    counted: bool
    """False: this (view, cover state) was counted before; geometry only."""
    detections: tuple[Detection, ...]
    """The representatives, answered."""
    covered: bool = False
    """Whether the container is covered, as last verified, this look included."""


class Track(Message, frozen=True, eq=False):
    """A persistent object; geometry from its newest detection."""

    id: int
    center_world_m: Xyz
    solid: Box3d | None
    points_world_m: NDArray[np.float32]
    hist: tuple[float, ...] | None
    n_observations: int
    y0: str | None
    """Latest counted observation."""
    last_detection: Name
    last_step: int

    def __post_init__(self) -> None:
        arrays.check("points_world_m", self.points_world_m, np.float32, (None, 3))


class Assigned(Message, frozen=True):
    """What became of one detection."""

    detection: Name
    track: int | None
    y: str | None
    counted: bool


class BeliefReply(Message, frozen=True, eq=False):
    """Tracks, b_t and the conformal set after the step."""

    episode: Name
    step: int
    tracks: tuple[Track, ...]
    assigned: tuple[Assigned, ...]
    prior: dict[str, float]
    """After first belief or birth, before the floor and the likelihoods."""
    belief: dict[str, float]
    """Hypothesis to probability: tracks by id, then unobs, then abs."""
    gamma: tuple[str, ...]
    q_hat: Threshold
    digest: Name
    """Of the whole state; replay gives the same bits."""
