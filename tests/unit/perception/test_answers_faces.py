"""Pixels come to lie where their rays meet the solid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.geometry import Array
from surefetch.perception.answers.faces import lay
from surefetch.perception.solids import KINDS, Kind, Solid

EYE = np.array([-0.5, -0.2, 0.45])


def solid(kind: Kind, yaw: float = 0.3, size: tuple[float, float] = (0.05, 0.07)) -> Solid:
    if kind != "box":
        size = (size[0], size[0])
    top = size[0] - 0.002 if kind == "ball" else 0.06
    return Solid(kind, 0.03, -0.02, yaw, size, 0.0, top, 0.3)


@settings(deadline=None)
@given(st.floats(-3.0, 3.0), st.floats(-0.95, 0.95), st.floats(-0.95, 0.95))
def test_a_ray_to_a_point_of_a_boxs_top_lands_there(yaw: float, a: float, b: float) -> None:
    box = solid("box", yaw)
    own = np.array([a * box.size_m[0] / 2, b * box.size_m[1] / 2])
    c, s = np.cos(yaw), np.sin(yaw)
    point = np.array([box.x_m + c * own[0] - s * own[1], box.y_m + s * own[0] + c * own[1], 0.06])
    laid = lay(box, (point - EYE)[None], EYE)
    assert laid.met[0] and laid.on_top[0]
    assert laid.own_m[0] == pytest.approx([*own, 0.03], abs=1e-9)
    assert laid.distance_m[0] == pytest.approx(np.linalg.norm(point - EYE))


def fan_of_rays(around: Array) -> Array:
    """Rays (n, 3) to and past a body."""
    across = np.cross(around - EYE, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    up = np.cross(across, around - EYE) / np.linalg.norm(around - EYE)
    a, b = np.meshgrid(np.linspace(-0.07, 0.07, 41), np.linspace(-0.07, 0.07, 41))
    rays: Array = around - EYE + a.reshape(-1, 1) * across + b.reshape(-1, 1) * up
    return rays


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_met_lies_on_the_surface_and_faces_the_eye(kind: Kind) -> None:
    one = solid(kind)
    laid = lay(one, fan_of_rays(np.array([one.x_m, one.y_m, 0.03])), EYE)
    assert 100 < np.count_nonzero(laid.met) < len(laid.met)
    assert (laid.cosine[laid.met] > 0.0).all()
    own, half_z = laid.own_m[laid.met], 0.03
    radius = np.hypot(own[:, 0], own[:, 1])
    if kind == "ball":
        assert np.linalg.norm(own, axis=1) == pytest.approx(0.025, abs=1e-9)
        return
    top = laid.on_top[laid.met]
    assert own[top, 2] == pytest.approx(half_z, abs=1e-9)
    assert (np.abs(own[~top, 2]) <= half_z + 1e-9).all()
    if kind == "cylinder":
        assert radius[~top] == pytest.approx(0.025, abs=1e-4)
    if kind == "hexagonal prism":
        assert (radius[~top] >= 0.025 - 1e-9).all()
        assert (radius[~top] <= 0.025 * 2 / np.sqrt(3) + 1e-9).all()


@pytest.mark.parametrize("kind", KINDS)
def test_the_nearest_surface_is_met_first(kind: Kind) -> None:
    one = solid(kind)
    rays = fan_of_rays(np.array([one.x_m, one.y_m, 0.03]))
    laid = lay(one, rays, EYE)
    unit = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    shorter = EYE + 0.98 * laid.distance_m[:, None] * unit
    beyond = np.hypot(shorter[:, 0] - one.x_m, shorter[:, 1] - one.y_m)
    outside = (beyond > 0.02) | (shorter[:, 2] > 0.03)
    assert outside[laid.met].all()
