"""Fits find the solid whose surface and silhouette were seen."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.geometry import Array, intrinsics, inverse, look_at, project, transform
from surefetch.perception import solids
from surefetch.perception.solids import Seen, View

K = intrinsics(640, 480, 50.0)
EYE = np.array([-0.45, -0.10, 0.45])
T_WORLD_CAMERA = look_at(EYE, np.zeros(3), np.array([0.0, 0.0, 1.0]))
VIEW = View(K, inverse(T_WORLD_CAMERA), EYE)


def box_surface(rng: np.random.Generator, size: Array, n: int) -> Array:
    """Points (n, 3) on an upright box from z = 0, and outward normals."""
    half = size / 2
    faces = rng.integers(0, 3, n)
    points = rng.uniform(-half, half, (n, 3))
    signs = np.where(rng.random(n) < 0.5, -1.0, 1.0)
    points[np.arange(n), faces] = signs * half[faces]
    standing: Array = points + [0.0, 0.0, half[2]]
    return standing


def seen_box(size: Array, yaw: float, at: Array, seed: int) -> Seen:
    """What the camera sees of a box: its three near faces, and its silhouette."""
    rng = np.random.default_rng(seed)
    own = box_surface(rng, size, 6000)
    c, s = np.cos(yaw), np.sin(yaw)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    eye_own = (EYE - np.append(at, 0.0)) @ R
    out = np.zeros_like(own)
    half = size / 2
    gaps = np.abs(np.abs(own - [0.0, 0.0, half[2]]) - half)
    face = gaps.argmin(1)
    out[np.arange(len(own)), face] = np.sign(own - [0, 0, half[2]])[np.arange(len(own)), face]
    visible = np.einsum("ni,ni->n", eye_own - own, out) > 0
    points = own @ R.T + np.append(at, 0.0)
    pixels = project(K, transform(VIEW.T_camera_world, points))
    shown = points[visible][: solids.N_POINTS]
    directions = np.arange(solids.N_OUTLINE) * 2 * np.pi / solids.N_OUTLINE
    middle = pixels.mean(0)
    farthest = [int(np.argmax((pixels - middle) @ [np.cos(a), np.sin(a)])) for a in directions]
    rays = shown - EYE
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    shown = shown + rays * rng.normal(0.0, 0.0005, (len(shown), 1))
    return Seen(
        points_m=shown,
        sigma_m=np.full(len(shown), 0.0015),
        outline_px=pixels[farthest],
        outline_weight=np.ones(solids.N_OUTLINE),
        base_m=0.0,
        center_m=at + rng.uniform(-0.008, 0.008, 2),
        width_m=float(size[:2].mean()),
        top_m=float(size[2]),
        yaw_rad=0.0,
    )


@settings(deadline=None, max_examples=15)
@given(
    st.floats(0.03, 0.07),
    st.floats(0.03, 0.07),
    st.floats(0.03, 0.09),
    st.floats(-0.7, 0.7),
    st.integers(0, 10_000),
)
def test_a_box_is_measured_to_millimetres(
    a: float, b: float, height: float, yaw: float, seed: int
) -> None:
    at = np.array([0.02, -0.01])
    fits = solids.fit([seen_box(np.array([a, b, height]), yaw, at, seed)], VIEW)[0]
    box = fits["box"]
    assert np.hypot(box.x_m - at[0], box.y_m - at[1]) < 0.003
    assert sorted(box.size_m) == pytest.approx(sorted((a, b)), abs=0.005)
    assert box.top_m == pytest.approx(height, abs=0.002)
    assert box.rms < fits["ball"].rms


def test_objects_are_fitted_independently_of_each_other() -> None:
    one = seen_box(np.array([0.04, 0.05, 0.06]), 0.2, np.array([0.0, 0.0]), 1)
    two = seen_box(np.array([0.06, 0.03, 0.04]), -0.3, np.array([0.1, 0.05]), 2)
    alone = solids.fit([two], VIEW)[0]["box"]
    together = solids.fit([one, two], VIEW)[1]["box"]
    assert together.x_m == pytest.approx(alone.x_m, abs=1e-9)
    assert together.rms == pytest.approx(alone.rms, abs=1e-9)


def test_nothing_to_fit_gives_nothing() -> None:
    assert solids.fit([], VIEW) == []
