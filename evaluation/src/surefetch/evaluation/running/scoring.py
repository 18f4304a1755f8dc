"""What a live episode was worth, by the scene's own truth and the fingers' contacts. Pure."""

import colorsys
from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.hypotheses import Relation
from surefetch.common.messages import Body, Ended, Rgb, Scene, Target, Truth
from surefetch.evaluation.running.metrics import Verdict, verdict
from surefetch.evaluation.scenes.appearance import COLORS

GREY_SATURATION: Final = 0.25
"""Below it a colour is white or black; every other named colour is far above."""
PLAIN: Final = "plain"


@dataclass(frozen=True)
class Asked:
    """The body that an instruction means on this table."""

    body: str | None
    """None: there is no such body."""
    unique: bool = True


@dataclass(frozen=True)
class Score:
    """How an episode counts. None: that cannot be told."""

    verdict: Verdict | None
    correct: bool | None


UNKNOWN: Final = Score(None, None)


def score(ended: Ended, asked: Asked, truth: Truth | None) -> Score:
    """Success as the paper counts it, and else the class of the failure.

    Args:
        ended: the planner's account.
        asked: what it should have fetched.
        truth: after the episode; None when the simulated cell is gone.
    """
    if ended.outcome not in ("aborted", "stopped") and (truth is None or not asked.unique):
        return UNKNOWN
    found = verdict(
        ended.outcome,
        ended.reason,
        target=asked.body,
        grasped=() if truth is None else truth.touched,
        anything_seen=any(step.observations for step in ended.steps),
    )
    return Score(found, found == "success")


def meant(target: Target, scene: Scene) -> Asked:
    """What a sentence of the user's own means on this table, by the bodies' own attributes."""
    fitting = [body.name for body in scene.bodies if fits(body, target, scene)]
    return Asked(fitting[0] if len(fitting) == 1 else None, unique=len(fitting) <= 1)


def fits(body: Body, target: Target, scene: Scene) -> bool:
    """Whether every named attribute and the relation hold of a body."""
    marking = PLAIN if body.marking is None else body.marking.kind
    return (
        target.color in (None, color_name(body.rgb))
        and target.shape in (None, body.shape)
        and target.marking in (None, marking)
        and target.relation in ("any", relation(body, scene))
    )


def color_name(rgb: Rgb) -> str:
    """The named colour nearest to a body's own, which is a jittered one."""
    hue, saturation, value = colorsys.rgb_to_hsv(*rgb)
    if saturation < GREY_SATURATION:
        return "white" if value > 0.5 else "black"
    hues = {name: h for name, (h, s, _) in COLORS.items() if s > GREY_SATURATION}
    return min(hues, key=lambda name: abs((hue * 360.0 - hues[name] + 180.0) % 360.0 - 180.0))


def relation(body: Body, scene: Scene) -> Relation:
    """Inside, when the centre of its footprint lies between the container's inner walls."""
    container = scene.container
    if container is None:
        return "outside"
    offset = np.subtract(body.position_world_m, container.position_world_m)[:2]
    cos, sin = np.cos(container.yaw_rad), np.sin(container.yaw_rad)
    along = abs(cos * offset[0] + sin * offset[1]), abs(cos * offset[1] - sin * offset[0])
    half = np.asarray(container.inner_size_m) / 2.0
    return "inside" if along[0] < half[0] and along[1] < half[1] else "outside"
