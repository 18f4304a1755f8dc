"""Every scorer keeps the port's promises."""

from collections.abc import Callable

import msgspec
import pytest
from rendered import perceive, shoot
from tabletop import body, box, scene

from surefetch.common.hypotheses import IDENTITY_LABELS, MEMBERSHIP_LABELS
from surefetch.common.messages import Answer, Target
from surefetch.common.observations import first_of_largest
from surefetch.perception.answers.scorer import ClassicalScorer
from surefetch.perception.candidate import SceneView
from surefetch.perception.ports import Scorer

SCORERS: dict[str, Callable[[], Scorer]] = {"classical": ClassicalScorer}
ALL = Target(noun="cube", color="red", shape="cube", marking="plain", relation="inside")


@pytest.fixture(scope="module")
def view() -> SceneView:
    inside = body("inside", "cylinder", (0.04, 0.04, 0.06), (1.0, 0.03))
    shot = shoot(
        scene(body("cube", at_m=(0.84, -0.16)), inside, container=box(covered=False)), "close_high"
    )
    return perceive(shot.frame, ALL).scene


@pytest.mark.parametrize("name", sorted(SCORERS))
def test_every_candidate_gets_all_asked_answers_in_order(name: str, view: SceneView) -> None:
    answers = SCORERS[name]().score(view, view.candidates, ALL)
    backwards = SCORERS[name]().score(view, view.candidates[::-1], ALL)
    assert len(answers) == len(view.candidates) == 2
    assert answers == backwards[::-1]
    for one in answers:
        for answer in (one.color, one.shape, one.marking):
            _check(answer, IDENTITY_LABELS)
        _check(one.membership, MEMBERSHIP_LABELS)


def _check(answer: Answer | None, labels: tuple[str, ...]) -> None:
    assert answer is not None
    assert answer.label == first_of_largest(labels, answer.scores)


@pytest.mark.parametrize("name", sorted(SCORERS))
@pytest.mark.parametrize("left_out", ["color", "shape", "marking"])
def test_what_the_target_lacks_is_not_asked(name: str, left_out: str, view: SceneView) -> None:
    answers = SCORERS[name]().score(
        view, view.candidates, msgspec.structs.replace(ALL, **{left_out: None})
    )
    for one in answers:
        told = {question: getattr(one, question) for question in ("color", "shape", "marking")}
        assert [question for question, answer in told.items() if answer is None] == [left_out]


@pytest.mark.parametrize("name", sorted(SCORERS))
def test_inside_and_outside_are_told_apart(name: str, view: SceneView) -> None:
    answers = SCORERS[name]().score(view, view.candidates, ALL)
    told = {one.membership.label for one in answers}
    assert told == {"inside", "outside"}


@pytest.mark.parametrize("name", sorted(SCORERS))
def test_answers_do_not_depend_on_who_else_is_asked_about(name: str, view: SceneView) -> None:
    together = SCORERS[name]().score(view, view.candidates, ALL)
    alone = [SCORERS[name]().score(view, [one], ALL)[0] for one in view.candidates]
    assert list(together) == alone
