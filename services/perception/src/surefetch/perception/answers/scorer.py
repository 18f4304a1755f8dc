"""The four answers to each candidate, from its pixels and fitted solids. Pure."""

from collections.abc import Sequence

from surefetch.common.messages import Answers, Target
from surefetch.perception.answers.color import color
from surefetch.perception.answers.look import look_at
from surefetch.perception.answers.marking import marking
from surefetch.perception.answers.membership import membership
from surefetch.perception.answers.shape import shape
from surefetch.perception.candidate import Candidate, SceneView


class ClassicalScorer:
    """Answers by geometry and colour, without weights; a `Scorer`."""

    def score(
        self, scene: SceneView, candidates: Sequence[Candidate], target: Target
    ) -> tuple[Answers, ...]:
        """Answers to each candidate, in order. Attributes that the target lacks are not asked."""
        return tuple(_answers(scene, candidate, target) for candidate in candidates)


def _answers(scene: SceneView, candidate: Candidate, target: Target) -> Answers:
    look = look_at(scene.surface, candidate)
    pose_known = scene.surface.frame.T_world_camera is not None
    return Answers(
        color=None if target.color is None else color(look, target.color),
        shape=None if target.shape is None else shape(look, target.shape),
        marking=(
            None if target.marking is None else marking(look, target.marking, pose_known=pose_known)
        ),
        membership=membership(candidate, scene.container),
    )
