"""An episode is scored by the scene's truth; a sentence of the user's own by what it says."""

import made_up_episode
import numpy as np
import pytest
from msgspec.structs import replace

from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import Scene, Target, Truth
from surefetch.evaluation.running import scoring
from surefetch.evaluation.running.scoring import Asked, Score
from surefetch.evaluation.scenes import appearance

ENDED = made_up_episode.ended()


def truth(*touched: str) -> Truth:
    return Truth(
        bodies=(), lid_position_world_m=None, touched=touched, held=None, segmentation=None
    )


def cylinder(
    color: str | None = "red", marking: str | None = None, relation: AskedRelation = "any"
) -> Target:
    return Target(
        noun="cylinder", color=color, shape="cylinder", marking=marking, relation=relation
    )


def with_twin_in_the_box() -> Scene:
    scene = made_up_episode.scene()
    assert scene.container is not None
    x, y, _ = scene.container.position_world_m
    twin = made_up_episode.body("twin", (0.76, 0.13, 0.11), (x + 0.05, y), marked=True)
    return replace(scene, bodies=(*scene.bodies, twin))


def test_a_sentence_means_the_one_body_that_fits() -> None:
    scene = made_up_episode.scene()
    assert scoring.meant(cylinder("red"), scene) == Asked("red cylinder")
    assert scoring.meant(cylinder("green"), scene) == Asked(None)
    assert scoring.meant(cylinder(None), scene) == Asked(None, unique=False)


def test_marking_and_relation_tell_twins_apart() -> None:
    scene = with_twin_in_the_box()
    assert not scoring.meant(cylinder("red"), scene).unique
    assert scoring.meant(cylinder("red", "stripe"), scene) == Asked("twin")
    assert scoring.meant(cylinder("red", "plain"), scene) == Asked("red cylinder")
    assert scoring.meant(cylinder("red", relation="inside"), scene) == Asked("twin")
    assert scoring.meant(cylinder("red", relation="outside"), scene) == Asked("red cylinder")


@pytest.mark.parametrize("name", sorted(appearance.COLORS))
def test_a_jittered_colour_keeps_its_name(name: str) -> None:
    rng = np.random.default_rng(3)
    for _ in range(50):
        assert scoring.color_name(appearance.jittered(appearance.COLORS[name], rng)) == name


def test_an_ambiguous_sentence_is_not_scored() -> None:
    assert scoring.score(ENDED, Asked(None, unique=False), truth("a")) == Score(None, None)


def test_an_end_without_the_truth_is_not_scored() -> None:
    assert scoring.score(ENDED, Asked("a"), None) == Score(None, None)


def test_contacts_decide() -> None:
    assert scoring.score(ENDED, Asked("a"), truth("a")) == Score("success", True)
    assert scoring.score(ENDED, Asked("a"), truth("b", "a")) == Score("wrong_object", False)


def test_an_abort_counts_as_a_failure_even_without_the_truth() -> None:
    ended = replace(ENDED, outcome="aborted")
    assert scoring.score(ended, Asked("a"), None) == Score("aborted", False)
