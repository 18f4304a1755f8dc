"""Light changes brightness; tones stay apart."""

import colorsys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from surefetch.perception.answers.tones import hue_gap, main_hue, tones_of
from surefetch.perception.histogram import hsv_of

LIGHT, DARK = (0.93, 0.93, 0.91), (0.07, 0.07, 0.08)
HUES = st.floats(0.0, 359.0)


def lit(rgb: tuple[float, ...], n: int, seed: int) -> NDArray[np.uint8]:
    """Pixels (n, 3) of one colour from deep shadow to full light, with grain."""
    rng = np.random.default_rng(seed)
    shade = rng.uniform(0.42, 1.05, (n, 1))
    noisy = np.asarray(rgb) * shade * 255.0 + rng.normal(0.0, 2.0, (n, 3))
    return np.asarray(np.clip(noisy, 0, 255), dtype=np.uint8)


@settings(deadline=None, max_examples=60)
@given(HUES, st.floats(0.6, 0.95), st.floats(0.5, 0.95), st.sampled_from([LIGHT, DARK]), HUES)
def test_a_marking_is_set_apart_from_a_coloured_body_in_any_light(
    hue: float, saturation: float, value: float, mark: tuple[float, ...], seed: float
) -> None:
    body = lit(colorsys.hsv_to_rgb(hue / 360.0, saturation, value), 300, int(seed))
    marking = lit(mark, 120, int(seed) + 1)
    tones = tones_of(np.concatenate([body, marking]))
    assert tones.colored
    assert np.count_nonzero(tones.other[:300]) <= 3
    assert np.count_nonzero(tones.other[300:]) >= 117


@pytest.mark.parametrize(("body", "mark"), [(LIGHT, DARK), (DARK, LIGHT)])
def test_black_and_white_are_set_apart_in_light_and_shadow(
    body: tuple[float, ...], mark: tuple[float, ...]
) -> None:
    tones = tones_of(np.concatenate([lit(body, 300, 1), lit(mark, 120, 2)]))
    assert not tones.colored
    assert not tones.other[:300].any()
    assert tones.other[300:].all()


@pytest.mark.parametrize("rgb", [LIGHT, DARK, (0.78, 0.12, 0.10), (0.12, 0.28, 0.75)])
def test_shadows_are_no_marking(rgb: tuple[float, ...]) -> None:
    assert not tones_of(lit(rgb, 400, 3)).other.any()


@settings(deadline=None)
@given(HUES, st.integers(0, 1000))
def test_the_main_hue_is_found_around_the_circle(hue: float, seed: int) -> None:
    hsv = hsv_of(lit(colorsys.hsv_to_rgb(hue / 360.0, 0.8, 0.8), 200, seed))
    assert hue_gap(main_hue(hsv[:, 0], hsv[:, 1]), hue) < 2.0
