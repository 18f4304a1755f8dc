"""The support is found in a cloud, with a pose or without."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.geometry import Array, deproject, inverse, look_at, project, transform
from surefetch.perception.support_plane import find_support, levelled

UP = np.array([0.0, 0.0, 1.0])


def eyes() -> st.SearchStrategy[Array]:
    return st.tuples(st.floats(0.4, 1.1), st.floats(-1.2, 1.2), st.floats(0.45, 1.4)).map(
        lambda e: e[0] * np.array([-np.cos(e[1]) * np.cos(e[2]), np.sin(e[1]) * 0.5, np.sin(e[2])])
    )


def table_with_a_box(T_world_camera: Array, seed: int = 0) -> Array:
    """Noisy camera-frame points (n, 3) of a table and of something on it."""
    rng = np.random.default_rng(seed)
    table = np.column_stack([rng.uniform(-0.4, 0.4, (2500, 2)), np.zeros(2500)])
    box = np.column_stack([rng.uniform(-0.08, 0.08, (900, 2)), np.full(900, 0.07)])
    points = transform(inverse(T_world_camera), np.concatenate([table, box]))
    return points + rng.normal(0.0, 0.0008, points.shape)


@settings(deadline=None, max_examples=25)
@given(eyes(), st.booleans())
def test_the_table_is_found_and_becomes_level(eye: Array, pose_known: bool) -> None:
    T = look_at(eye, np.zeros(3), UP)
    points = table_with_a_box(T)
    known = T if pose_known else None
    plane = find_support(points, known)
    assert plane is not None
    T_level, support_z = levelled(plane, known)
    heights = transform(T_level, points)[:2500, 2] - support_z
    assert abs(float(np.mean(heights))) < 0.001
    assert float(np.std(heights)) < 0.0015
    assert support_z == 0.0


@settings(deadline=None, max_examples=25)
@given(eyes())
def test_a_known_pose_moves_by_no_more_than_its_own_error(eye: Array) -> None:
    T = look_at(eye, np.zeros(3), UP)
    plane = find_support(table_with_a_box(T), T)
    assert plane is not None
    T_level, _ = levelled(plane, T)
    assert np.abs(T_level - T).max() < 0.005


def test_a_wall_alone_is_no_support() -> None:
    rng = np.random.default_rng(0)
    eye = np.array([-0.6, 0.0, 0.3])
    T = look_at(eye, np.array([0.0, 0.0, 0.25]), UP)
    wall = np.column_stack([np.zeros(2000), rng.uniform(-0.4, 0.4, 2000), rng.uniform(0, 1, 2000)])
    assert find_support(transform(inverse(T), wall), T) is None


@settings(deadline=None)
@given(st.floats(0.0, 639.0), st.floats(0.0, 479.0), st.floats(0.2, 2.5), st.floats(300.0, 900.0))
def test_projecting_a_lifted_pixel_gives_the_pixel(u: float, v: float, z: float, f: float) -> None:
    K = np.array([[f, 0.0, 311.3], [0.0, f * 1.02, 244.9], [0.0, 0.0, 1.0]])
    pixel = np.array([[u, v]])
    assert project(K, deproject(K, pixel, np.array([z]))) == pytest.approx(pixel, abs=1e-6)
