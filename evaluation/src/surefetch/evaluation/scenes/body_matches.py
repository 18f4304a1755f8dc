"""Which bodies of a generated scene are what a target asks for, and where they stand."""

from surefetch.common.messages import Scene, Target
from surefetch.evaluation.recordings.recording import BodyMatch
from surefetch.evaluation.scenes.candidate import plan_of
from surefetch.evaluation.scenes.plan import Attributes, Part


def body_matches(scene: Scene, target: Target) -> dict[str, BodyMatch]:
    """For each body, by name, which of the attributes that the target names it has.

    Raises:
        ValueError: the scene is not the one that its family and seed generate.
    """
    parts = plan_of(scene.family, scene.seed).parts
    return {body.name: _match(part, target) for part, body in zip(parts, scene.bodies, strict=True)}


def _match(part: Part, target: Target) -> BodyMatch:
    has = part.attributes
    return BodyMatch(
        color=_same(has, "color", target.color),
        shape=_same(has, "shape", target.shape),
        marking=_same(has, "marking", target.marking),
        relation=part.relation,
    )


def _same(has: Attributes, attribute: str, asked: str | None) -> bool | None:
    return None if asked is None else bool(getattr(has, attribute) == asked)
