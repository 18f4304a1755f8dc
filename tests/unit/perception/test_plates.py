"""Upright plates are told from bodies by their upper edge."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.geometry import Array
from surefetch.perception.plates import are_plates, strips


def plate(
    rng: np.random.Generator, length: float, height: float, yaw: float, at: Array, n: int = 500
) -> Array:
    """Points (n, 3) on the front and the upper edge of a plate 8 mm thick, with noise."""
    u = rng.uniform(-length / 2, length / 2, n)
    on_top = rng.random(n) < 0.12
    v = np.where(on_top, rng.uniform(0, 0.008, n), 0.0) + rng.normal(0, 0.0007, n)
    z = np.where(on_top, height, rng.uniform(0, height, n))
    c, s = np.cos(yaw), np.sin(yaw)
    return np.column_stack([u * c - v * s + at[0], u * s + v * c + at[1], z])


@settings(deadline=None, max_examples=40)
@given(st.floats(0.05, 0.14), st.floats(0.06, 0.18), st.floats(0.0, 3.1), st.integers(0, 10_000))
def test_a_plate_is_one(length: float, height: float, yaw: float, seed: int) -> None:
    assert are_plates(plate(np.random.default_rng(seed), length, height, yaw, np.zeros(2)))


@settings(deadline=None, max_examples=40)
@given(st.floats(0.07, 0.1), st.floats(0.0, 3.1), st.floats(1.2, 1.6), st.integers(0, 10_000))
def test_two_plates_at_a_corner_are_too(
    length: float, yaw: float, corner: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    end = length / 2 * np.array([np.cos(yaw), np.sin(yaw)])
    other = end + length / 2 * np.array([np.cos(yaw + corner), np.sin(yaw + corner)])
    first = plate(rng, length, 0.12, yaw, np.zeros(2))
    second = plate(rng, length, 0.12, yaw + corner, other)
    assert are_plates(np.concatenate([first, second]))


@settings(deadline=None, max_examples=40)
@given(st.floats(0.026, 0.08), st.floats(0.026, 0.08), st.floats(0.0, 3.1), st.integers(0, 10_000))
def test_a_body_with_a_top_is_none(a: float, b: float, yaw: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    front = np.column_stack([rng.uniform(-a / 2, a / 2, 500), np.full(500, -b / 2)])
    top = rng.uniform((-a / 2, -b / 2), (a / 2, b / 2), (250, 2))
    z = np.concatenate([rng.uniform(0, 0.08, 500), np.full(250, 0.08)])
    c, s = np.cos(yaw), np.sin(yaw)
    xy = np.concatenate([front, top]) @ np.array([[c, s], [-s, c]])
    assert not are_plates(np.column_stack([xy, z]))


@pytest.mark.parametrize("n", [1, 2, 5])
def test_strips_are_disjoint_and_fall_in_size(n: int) -> None:
    points = np.random.default_rng(1).uniform(-0.1, 0.1, (300, 2))
    found = strips(points, n)
    sizes = [int(strip.which.sum()) for strip in found]
    assert sizes == sorted(sizes, reverse=True)
    assert np.stack([strip.which for strip in found]).sum(0).max() == 1
