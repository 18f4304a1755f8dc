"""Fourteen bins that partition the pixels."""

import colorsys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from surefetch.common.likeness import hellinger
from surefetch.perception.histogram import N_BINS, histogram, hsv_of

Pixels = NDArray[np.uint8]


def pixels() -> st.SearchStrategy[Pixels]:
    return hnp.arrays(np.uint8, st.tuples(st.integers(1, 40), st.just(3)))


@settings(deadline=None)
@given(pixels())
def test_a_histogram_sums_to_one_and_counts_every_pixel_once(rgb: Pixels) -> None:
    bins = histogram(rgb)
    assert bins is not None
    assert len(bins) == N_BINS
    assert sum(bins) == pytest.approx(1.0)
    assert min(bins) >= 0.0


@settings(deadline=None)
@given(pixels(), st.randoms(use_true_random=False))
def test_the_order_of_pixels_does_not_matter(rgb: Pixels, random: object) -> None:
    assert histogram(rgb[::-1].copy()) == pytest.approx(histogram(rgb))


@settings(deadline=None)
@given(pixels())
def test_hue_saturation_and_value_are_the_usual_ones(rgb: Pixels) -> None:
    for ours, (r, g, b) in zip(hsv_of(rgb), rgb / 255.0, strict=True):
        h, s, v = colorsys.rgb_to_hsv(r, g, b)
        assert ours[2] == pytest.approx(v, abs=1e-5)
        assert ours[1] == pytest.approx(s, abs=1e-5)
        if s > 0:
            assert abs((ours[0] - 360 * h + 180) % 360 - 180) < 0.01


def test_no_pixels_have_no_histogram() -> None:
    assert histogram(np.zeros((0, 3), np.uint8)) is None


def test_a_little_more_light_moves_little_mass_and_another_colour_much() -> None:
    def of(r: int, g: int, b: int) -> tuple[float, ...] | None:
        return histogram(np.full((50, 3), (r, g, b), np.uint8))

    assert hellinger(of(180, 40, 30), of(200, 45, 34)) < 0.15
    assert hellinger(of(180, 40, 30), of(40, 60, 180)) > 0.9
