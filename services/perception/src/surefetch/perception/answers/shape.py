"""Which of the shapes a body has. Pure."""

from typing import Final

from surefetch.common.messages import Answer
from surefetch.perception.answers.answer import identity
from surefetch.perception.answers.boxes import cube_or_block
from surefetch.perception.answers.look import Look
from surefetch.perception.candidate import Candidate
from surefetch.perception.solids import Kind, Solid

SOLIDS: Final[dict[str, Kind]] = {
    "cube": "box",
    "block": "box",
    "cylinder": "cylinder",
    "ball": "ball",
    "hexagonal prism": "hexagonal prism",
}
RMS_UNIT: Final = 0.05
"""Residuals this far apart are told apart, if the body is well seen."""
GOOD_RMS: Final = 0.6
"""Right solids fit at least this well."""
WELL_SEEN_PX: Final = 150
FREE_OCCLUSION: Final = 0.12
BOX_UNIT_PX: Final = 10.0
BOX_UNIT_SHARE: Final = 0.03


def shape(look: Look, asked: str) -> Answer:
    """Whether the body has the asked shape.

    The margin is by how much its solid fits better than all others; of boxes, also by how many
    pixels fewer speak against a cube, or against a block.
    """
    candidate = look.candidate
    evidence = {"n_px": float(candidate.n_px), "occluded": candidate.occluded_share}
    if not candidate.fits:
        return identity(0.0, 1.0, evidence)
    rms = {kind: solid.rms for kind, solid in candidate.fits.items()}
    kind = SOLIDS[asked]
    margin = min(r for other, r in rms.items() if other != kind) - rms[kind]
    score = margin / (RMS_UNIT * _doubt(candidate))
    evidence |= {f"rms_{name}": r for name, r in rms.items()}
    if kind == "box" and score > -1.0:
        longer = _longer(look, candidate.fits["box"])
        evidence["block_score"] = longer
        score = min(score, longer if asked == "block" else -longer)
    return identity(score, 1.0, evidence)


def _longer(look: Look, box: Solid) -> float:
    """How much rather a block than a cube."""
    found = cube_or_block(look.window, box)
    unit = BOX_UNIT_PX + BOX_UNIT_SHARE * look.candidate.n_px
    return (found.against_cube_px - found.against_block_px) / unit


def _doubt(candidate: Candidate) -> float:
    """Factor on the unit: more for what is hidden, small, cut, or fitted by no solid."""
    hidden = max(0.0, candidate.occluded_share - FREE_OCCLUSION)
    small = max(0.0, 1.0 - candidate.n_px / WELL_SEEN_PX)
    misfit = max(0.0, min(solid.rms for solid in candidate.fits.values()) - GOOD_RMS)
    cut = candidate.border_share
    return (1.0 + 8.0 * hidden) * (1.0 + 4.0 * small) * (1.0 + 10.0 * cut) * (1.0 + 5.0 * misfit)
