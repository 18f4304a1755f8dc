"""What is true of a generated scene: the scorer reads it, and nobody else."""

from surefetch.common.hypotheses import Relation
from surefetch.common.messages import Message, Name
from surefetch.evaluation.recordings.recording import Cover


class Sighting(Message, frozen=True):
    """How much of one body one view shows, by a segmentation render without errors of pose."""

    body: Name
    view: Name
    cover: Cover
    share: float
    """Its pixels over its pixels when everything else is moved away."""
    pixels: float
    """In the camera's full resolution."""
    patch_px: float
    """Of its marking, or of where a plain body's marking would be, seen less than 70° aslant."""
    patch_share: float
    """Of the patch's pixels when everything else is moved away, or 0 when it faces away."""
    over_container: float
    """Share of its outline whose sight lines cross the container's box."""


class SceneTruth(Message, frozen=True):
    """Truth of one scene, and why earlier attempts at it were rejected."""

    family: Name
    seed: int
    generator_version: int
    attempts: int
    """1 when the first attempt was accepted."""
    rejected: dict[str, int]
    """Rejected attempts by reason."""
    stratum: str
    target: str | None
    """The body that the sentence means; None when there is none."""
    relation: Relation | None
    near_misses: tuple[str, ...]
    twins: tuple[str, ...]
    too_wide: tuple[str, ...]
    """Bodies that no opening of the hand fits."""
    sightings: tuple[Sighting, ...]
    """Of target, twins and near-misses in every state."""
    evidence: dict[str, float]
    """Measured values behind the accepted rules, in metres, seconds and shares."""

    def sighting(self, body: str, view: str, cover: Cover) -> Sighting:
        """One of them. Raises KeyError."""
        for one in self.sightings:
            if (one.body, one.view, one.cover) == (body, view, cover):
                return one
        raise KeyError((body, view, cover))
