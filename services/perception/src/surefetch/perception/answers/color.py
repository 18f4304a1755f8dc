"""Which of the named colours a body has. Pure.

A marking's pixels do not count. Hue is the measure for colours that have one, since light and
shadow leave it alone; white and black are told by brightness.
"""

from typing import Final

import numpy as np

from surefetch.common.messages import Answer
from surefetch.perception.answers.answer import SURE, identity
from surefetch.perception.answers.faces import Bools
from surefetch.perception.answers.look import Look
from surefetch.perception.answers.tones import GREY_VALUE, hue_gap, main_hue

HUES_DEG: Final[dict[str, float]] = {
    "red": 2.0,
    "orange": 26.0,
    "yellow": 52.0,
    "green": 130.0,
    "blue": 218.0,
    "purple": 284.0,
}
OTHER_HUES_DEG: Final = (90.0, 174.0, 330.0)
"""Lime, cyan and pink: none of the named."""
COLORS: Final = (*HUES_DEG, "white", "black")
HUE_UNIT_DEG: Final = 2.0
GREY_UNIT: Final = 0.12
WELL_SEEN_PX: Final = 60
RIVAL_PX: Final = 12.0
RIVAL_COST_SHARE: Final = 0.5
"""Which of two tones is the body's must make this much difference, more where neither explains
the picture well."""
STRAY_HUE_SHARE: Final = 0.02
HUE_DOUBT: Final = 200.0


def color(look: Look, asked: str) -> Answer:
    """Whether the body has the asked colour."""
    own = ~look.marked
    n_px = float(np.count_nonzero(own)) * look.share
    doubt = 1.0 + 4.0 * max(0.0, 1.0 - n_px / WELL_SEEN_PX)
    if not own.any():
        return identity(0.0, doubt, {"body_px": n_px})
    margins, evidence = _chromatic(look, own) if look.tones.colored else _grey(look, own)
    if not look.tones.colored:
        doubt += _doubt_of_grey(look)
    return identity(margins[asked], doubt, evidence | {"body_px": n_px})


def _doubt_of_grey(look: Look) -> float:
    """A little hue may be all that is seen of a coloured body below its marking."""
    hidden_hue = max(0.0, look.tones.hue_share - STRAY_HUE_SHARE)
    left = min((found.cost_px for found in look.explanations.values()), default=0.0)
    undecided = bool(look.explanations) and look.rival_px < RIVAL_PX + RIVAL_COST_SHARE * left
    return HUE_DOUBT * hidden_hue + (2 * SURE if undecided else 0.0)


def _chromatic(look: Look, own: Bools) -> tuple[dict[str, float], dict[str, float]]:
    hsv = look.tones.hsv
    steady = own & ~look.tones.clipped
    used = steady if np.count_nonzero(steady) >= 20 else own
    hue = main_hue(hsv[used, 0], hsv[used, 1] * hsv[used, 2])
    away = {n: hue_gap(hue, c) for n, c in HUES_DEG.items()}
    unnamed = min(hue_gap(hue, other) for other in OTHER_HUES_DEG)
    margins = {
        name: 0.5 * (min([unnamed, *(v for n, v in away.items() if n != name)]) - away[name])
        for name in away
    }
    scores = {name: margin / HUE_UNIT_DEG for name, margin in margins.items()}
    return scores | {"white": -SURE, "black": -SURE}, {"hue_deg": hue}


def _grey(look: Look, own: Bools) -> tuple[dict[str, float], dict[str, float]]:
    value = float(np.percentile(look.tones.hsv[own, 2], 85))
    light = float(np.log(max(value, 0.02) / GREY_VALUE) / GREY_UNIT)
    scores = dict.fromkeys(HUES_DEG, -SURE)
    return scores | {"white": light, "black": -light}, {"value": value}
