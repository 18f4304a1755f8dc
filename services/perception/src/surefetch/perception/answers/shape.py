"""Which of the shapes a body has. Pure."""

from typing import Final

import numpy as np

from surefetch.common.messages import Answer
from surefetch.perception.answers.answer import identity
from surefetch.perception.answers.look import rms_of
from surefetch.perception.candidate import Candidate
from surefetch.perception.solids import Kind, Solid

SOLIDS: Final[dict[str, Kind]] = {
    "cube": "box",
    "block": "box",
    "cylinder": "cylinder",
    "ball": "ball",
    "hexagonal prism": "hexagonal prism",
}
RMS_UNIT: Final = 0.12
"""Residuals this far apart are told apart."""
ASPECT: Final = float(np.sqrt(1.6))
"""Between a cube's longest by shortest side, 1, and a block's, at least 1.6."""
ASPECT_UNIT: Final = 0.12
WELL_SEEN_PX: Final = 150
FREE_OCCLUSION: Final = 0.12


def shape(candidate: Candidate, asked: str) -> Answer:
    """Whether the body has the asked shape."""
    evidence = {"n_px": float(candidate.n_px), "occluded": candidate.occluded_share}
    if not candidate.fits:
        return identity(0.0, 1.0, evidence)
    rms = rms_of(candidate)
    kind = SOLIDS[asked]
    margin = (min(r for other, r in rms.items() if other != kind) - rms[kind]) / RMS_UNIT
    evidence |= {f"rms_{name}": r for name, r in rms.items()}
    if kind == "box":
        tall = _aspect_margin(candidate.fits["box"])
        evidence["aspect_margin"] = tall
        margin = min(margin, tall if asked == "block" else -tall)
    return identity(margin, _doubt(candidate), evidence)


def _aspect_margin(box: Solid) -> float:
    sides = (*box.size_m, box.top_m - box.base_m)
    aspect = max(sides) / max(min(sides), 1e-3)
    return float(np.log(aspect / ASPECT) / ASPECT_UNIT)


def _doubt(candidate: Candidate) -> float:
    hidden = max(0.0, candidate.occluded_share - FREE_OCCLUSION)
    small = max(0.0, 1.0 - candidate.n_px / WELL_SEEN_PX)
    return 1.0 + 10.0 * hidden + 4.0 * small + 10.0 * candidate.border_share
