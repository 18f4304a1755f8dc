"""Laws of the conformal threshold and set; agreed numbers are in the golden cases."""

import math
from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.conformal import (
    conformal_set,
    coverage_range,
    episode_score,
    quantile,
    rank,
)

laws = settings(deadline=None)
probabilities = st.floats(0.0, 1.0)
scores = st.lists(probabilities, max_size=40)
alphas = st.fractions(Fraction(1, 100), Fraction(1, 2), max_denominator=100)
beliefs = st.dictionaries(st.text(max_size=3), probabilities, max_size=6)


@laws
@given(scores, alphas, st.randoms())
def test_the_threshold_does_not_depend_on_the_order_of_episodes(
    rho: list[float], alpha: Fraction, random: object
) -> None:
    shuffled = sorted(rho, key=lambda _: random.random())  # type: ignore[attr-defined]
    assert quantile(rho, alpha) == quantile(shuffled, alpha)


@laws
@given(scores, alphas)
def test_the_threshold_leaves_enough_episodes_below_it(rho: list[float], alpha: Fraction) -> None:
    q_hat = quantile(rho, alpha)
    covered = sum(score <= q_hat for score in rho)
    assert covered == len(rho) or covered >= (len(rho) + 1) * (1 - alpha)


@laws
@given(scores, alphas, alphas, beliefs)
def test_a_smaller_alpha_gives_a_set_that_holds_the_larger_ones(
    rho: list[float], one: Fraction, other: Fraction, belief: dict[str, float]
) -> None:
    wide = conformal_set(belief, quantile(rho, min(one, other)))
    narrow = conformal_set(belief, quantile(rho, max(one, other)))
    assert set(narrow) <= set(wide)


@laws
@given(beliefs)
def test_without_enough_episodes_nothing_is_ruled_out(belief: dict[str, float]) -> None:
    assert conformal_set(belief, quantile([0.5], Fraction(1, 10))) == tuple(belief)


def test_the_rank_is_exact_where_floating_point_is_not() -> None:
    """(9 + 1)(1 - 0.1) is 9; 10 * (1 - 0.1) in floating point may round up from it."""
    assert [rank(n, Fraction(1, 10)) for n in (8, 9, 10, 19, 20)] == [9, 9, 10, 18, 19]
    assert rank(99, Fraction("0.29")) == 71


@laws
@given(st.lists(probabilities, min_size=1))
def test_an_episode_scores_as_at_its_worst_step(beliefs_in_truth: list[float]) -> None:
    assert episode_score(beliefs_in_truth) == 1.0 - min(beliefs_in_truth)


@pytest.mark.parametrize("n", [20, 200, 400])
def test_the_range_of_true_coverage_narrows_around_what_was_asked(n: int) -> None:
    low, high = coverage_range(n, Fraction(1, 10))
    assert low < 0.9 < high
    assert high - low < 4.0 * 1.65 * math.sqrt(0.09 / n)


def test_too_few_episodes_cover_everything() -> None:
    assert coverage_range(5, Fraction(1, 10)) == (1.0, 1.0)
