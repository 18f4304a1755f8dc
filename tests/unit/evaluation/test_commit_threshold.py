"""How sure a grasp must be: the lowest threshold that is surely safe, tested from the safest."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surefetch.evaluation.fitting.commit_threshold import AT_MOST, DELTA, Tried, lowest_safe


def tried(at_least: float, n_wrong: int, n: int = 1000) -> Tried:
    return Tried(at_least, n, n_wrong, n - n_wrong)


def test_the_bound_is_the_rate_that_would_hardly_give_so_few() -> None:
    none_in = 115
    assert tried(0.5, 0, none_in).upper_bound == pytest.approx(1.0 - DELTA ** (1 / none_in))
    assert tried(0.5, 10, 10).upper_bound == 1.0


def test_the_lowest_safe_one_is_chosen_whatever_the_order() -> None:
    found = [tried(0.0, 40), tried(0.9, 1), tried(0.5, 9), tried(0.7, 3)]
    chosen = lowest_safe(found)
    assert chosen is not None
    assert chosen.at_least == 0.5
    assert chosen == lowest_safe(found[::-1])


def test_what_lies_below_an_unsafe_one_is_never_chosen() -> None:
    chosen = lowest_safe([tried(0.9, 1), tried(0.7, 30), tried(0.5, 1)])
    assert chosen is not None
    assert chosen.at_least == 0.9
    assert lowest_safe([tried(0.9, 30), tried(0.5, 0)]) is None
    assert lowest_safe([]) is None


def test_few_episodes_prove_nothing() -> None:
    assert lowest_safe([tried(0.9, 0, 50)]) is None


@given(st.integers(0, 2**32 - 1))
def test_a_threshold_just_too_risky_is_chosen_no_oftener_than_promised(seed: int) -> None:
    wrong = np.random.default_rng(seed).binomial(600, AT_MOST, size=4000)
    bounds = {k: tried(0.5, int(k), 600).upper_bound for k in np.unique(wrong)}
    accepted = np.mean([bounds[k] < AT_MOST for k in wrong])
    assert accepted < DELTA + 4 * (DELTA / 4000) ** 0.5


@given(st.integers(0, 30), st.integers(100, 2000))
def test_more_wrong_grasps_never_lower_the_bound(n_wrong: int, n: int) -> None:
    assert tried(0.5, n_wrong, n).upper_bound < tried(0.5, n_wrong + 1, n).upper_bound
