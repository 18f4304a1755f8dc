"""Rims and plates in a top-down grid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.geometry import Array
from surefetch.perception.rectangle import CELL_M, Rectangle, find_outline, find_plates

RECTANGLES = st.builds(
    lambda yaw, u, v, a, b: Rectangle(yaw, (u - a / 2, u + a / 2), (v - b / 2, v + b / 2)),
    st.floats(-1.5, 1.5),
    st.floats(-0.3, 0.3),
    st.floats(0.5, 1.2),
    st.floats(0.15, 0.30),
    st.floats(0.15, 0.30),
)


def cells_of(points: Array) -> Array:
    """Centres of the grid cells that hold points (n, 2)."""
    centers: Array = (np.unique(np.floor(points / CELL_M), axis=0) + 0.5) * CELL_M
    return centers


def placed(rectangle: Rectangle, own: Array) -> Array:
    """Points (n, 2) given in the rectangle's axes from its centre, in the world."""
    c, s = np.cos(rectangle.yaw_rad), np.sin(rectangle.yaw_rad)
    moved: Array = own @ np.array([[c, s], [-s, c]]) + rectangle.center_m
    return moved


def rim(rectangle: Rectangle, rng: np.random.Generator) -> Array:
    """Points on the outline."""
    a, b = np.array(rectangle.size_m) / 2
    along = rng.uniform(-1, 1, 4000)
    side = rng.integers(0, 4, 4000)
    u = np.where(side < 2, along * a, np.where(side == 2, a, -a))
    v = np.where(side < 2, np.where(side == 0, b, -b), along * b)
    return placed(rectangle, np.column_stack([u, v]))


@settings(deadline=None)
@given(RECTANGLES, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2))
def test_inset_is_positive_inside_and_negative_outside(
    rectangle: Rectangle, u: float, v: float
) -> None:
    a, b = np.array(rectangle.size_m) / 2
    inset = float(rectangle.inset(placed(rectangle, np.array([[u, v]])))[0])
    assert inset == pytest.approx(min(a - abs(u), b - abs(v)), abs=1e-9)


@settings(deadline=None, max_examples=15)
@given(RECTANGLES, st.integers(0, 10_000))
def test_a_rim_is_found_among_clutter(rectangle: Rectangle, seed: int) -> None:
    rng = np.random.default_rng(seed)
    clutter = rng.uniform(-0.03, 0.03, (400, 2)) + rectangle.center_m
    found = find_outline(cells_of(np.concatenate([rim(rectangle, rng), clutter])))
    assert found is not None
    assert found.coverage > 0.8
    assert np.hypot(*np.subtract(found.center_m, rectangle.center_m)) < 0.006
    assert sorted(found.size_m) == pytest.approx(sorted(rectangle.size_m), abs=0.016)


@settings(deadline=None, max_examples=15)
@given(RECTANGLES, st.integers(0, 10_000))
def test_a_plate_is_found_beside_smaller_ones(rectangle: Rectangle, seed: int) -> None:
    rng = np.random.default_rng(seed)
    half = np.array(rectangle.size_m) / 2
    plate = placed(rectangle, rng.uniform(-half, half, (30_000, 2)))
    small = rng.uniform(-0.03, 0.03, (3000, 2)) + np.add(rectangle.center_m, (0.5, 0.0))
    found = find_plates(cells_of(np.concatenate([plate, small])))
    assert len(found) == 1
    assert np.hypot(*np.subtract(found[0].center_m, rectangle.center_m)) < 0.006
    assert sorted(found[0].size_m) == pytest.approx(sorted(rectangle.size_m), abs=0.016)


def test_nothing_is_found_in_nothing() -> None:
    assert find_outline(np.zeros((0, 2))) is None
    assert find_plates(np.zeros((0, 2))) == []
