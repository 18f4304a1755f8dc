"""Laws of rigid transforms and of the pinhole camera."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from surefetch.common.geometry import (
    deproject,
    intrinsics,
    inverse,
    look_at,
    project,
    rigid,
    rotation_angle,
    rotation_from_vector,
    rotation_z,
    transform,
)

Array = NDArray[np.float64]
laws = settings(deadline=None)
lengths = st.floats(-10.0, 10.0)
vectors = st.tuples(lengths, lengths, lengths).map(np.array)
rotvecs = st.tuples(*[st.floats(-1.8, 1.8)] * 3).map(np.array)
poses = st.builds(lambda r, t: rigid(rotation_from_vector(r), t), rotvecs, vectors)
points = st.lists(vectors, min_size=1, max_size=4).map(np.array)


def close(one: Any, other: Any) -> bool:
    return bool(np.allclose(one, other, atol=1e-9))


@laws
@given(poses, points)
def test_an_inverse_undoes(T: Array, p: Array) -> None:
    assert close(T @ inverse(T), np.eye(4))
    assert close(transform(inverse(T), transform(T, p)), p)


@laws
@given(poses, poses, points)
def test_transforms_compose(T_a_b: Array, T_b_c: Array, p_c: Array) -> None:
    assert close(transform(T_a_b @ T_b_c, p_c), transform(T_a_b, transform(T_b_c, p_c)))


@laws
@given(rotvecs)
def test_a_rotation_vector_makes_a_rotation_by_its_length(rotvec: Array) -> None:
    R = rotation_from_vector(rotvec)
    assert close(R @ R.T, np.eye(3))
    assert np.linalg.det(R) == pytest.approx(1.0)
    angle = float(np.linalg.norm(rotvec))
    wanted = min(angle, 2.0 * np.pi - angle)
    assert rotation_angle(R) == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("angle", [0.0, 1e-14, 1e-9, 1e-3, 1.0, np.pi])
def test_a_rotation_about_z_is_the_rotation_of_its_vector(angle: float) -> None:
    R = rotation_z(angle)
    assert close(R, rotation_from_vector(np.array([0.0, 0.0, angle])))
    assert rotation_angle(R) == pytest.approx(angle, rel=1e-6)


@laws
@given(st.integers(2, 2000), st.integers(2, 2000), st.floats(10.0, 120.0), st.data())
def test_projecting_undoes_deprojecting(
    width: int, height: int, fov_deg: float, data: st.DataObject
) -> None:
    K = intrinsics(width, height, fov_deg)
    pixel = st.tuples(st.floats(0, width - 1), st.floats(0, height - 1))
    pixels = np.array(data.draw(st.lists(pixel, min_size=1, max_size=4)))
    depth_m = np.array(data.draw(st.lists(st.floats(0.1, 5.0), min_size=4, max_size=4)))
    p_camera = deproject(K, pixels, depth_m[: len(pixels)])
    assert np.allclose(project(K, p_camera), pixels, atol=1e-6)
    assert close(p_camera[:, 2], depth_m[: len(pixels)])


def test_the_field_of_view_spans_the_image() -> None:
    K = intrinsics(640, 480, 50.0)
    top, bottom = deproject(K, np.array([[319.5, -0.5], [319.5, 479.5]]), np.ones(2))
    angle = np.arctan2(bottom[1], bottom[2]) - np.arctan2(top[1], top[2])
    assert np.degrees(angle) == pytest.approx(50.0)


@laws
@given(vectors, vectors)
def test_a_camera_that_looks_at_a_point_has_it_in_the_middle_and_up_is_up(
    eye: Array, target: Array
) -> None:
    line = target - eye
    if np.linalg.norm(np.cross(line, [0.0, 0.0, 1.0])) < 1e-3:
        return
    T = look_at(eye, target, np.array([0.0, 0.0, 1.0]))
    assert close(T[:3, :3] @ T[:3, :3].T, np.eye(3))
    assert np.linalg.det(T[:3, :3]) == pytest.approx(1.0)
    x, y, z = transform(inverse(T), target[None, :])[0]
    assert abs(x) < 1e-6
    assert abs(y) < 1e-6
    assert z == pytest.approx(np.linalg.norm(line))
    assert T[2, 1] <= 1e-12  # image-down, the camera's y, never points up
