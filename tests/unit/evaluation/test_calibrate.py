"""One score per episode, its worst step; too few episodes are refused."""

from fractions import Fraction

import pytest
from made_up_looks import look

from surefetch.common.errors import BadInput
from surefetch.evaluation.fitting.calibrate import calibrate, episodes_for, score

TENTH = Fraction(1, 10)


def test_an_episode_is_scored_at_its_worst_step() -> None:
    looks = [look("center", {}, p_truth=0.2), look("right", {}, p_truth=0.7)]
    assert score(looks) == pytest.approx(0.8)


def test_twenty_episodes_give_the_nineteenth_score() -> None:
    scores = [n / 20 for n in range(20)]
    assert calibrate(scores, TENTH).q_hat == scores[18]


def test_the_supported_coverage_narrows_with_the_episodes() -> None:
    few = calibrate([0.5] * 20, TENTH).true_coverage
    many = calibrate([0.5] * 200, TENTH).true_coverage
    assert few == pytest.approx((0.784, 0.982), abs=2e-3)
    assert many == pytest.approx((0.864, 0.933), abs=2e-3)


def test_paper_takes_twenty_and_extended_all() -> None:
    assert episodes_for("paper", 250) == 20
    assert episodes_for("extended", 250) == 250


@pytest.mark.parametrize(("profile", "available"), [("paper", 19), ("extended", 199)])
def test_too_few_episodes_are_refused(profile: str, available: int) -> None:
    with pytest.raises(BadInput, match=profile):
        episodes_for(profile, available)
