"""The simulated sensor's faults have the sizes that the cell promises."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from surefetch.common.geometry import rotation_angle
from surefetch.executor.simulation.pose_errors import arrival_error, hand_eye_error
from surefetch.executor.simulation.sensor_noise import (
    depth_sigma_m,
    near_step,
    noisy_depth,
    noisy_rgb,
)

BRIGHT = np.full((200, 200, 3), 128, np.uint8)
DARK = np.full((200, 200, 3), 30, np.uint8)


def flat(depth_m: float) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    return np.full((200, 200), depth_m, np.float32)


@given(st.floats(0.3, 2.0))
def test_noise_is_half_a_millimetre_and_grows_with_the_square_of_depth(depth_m: float) -> None:
    noisy = noisy_depth(flat(depth_m), BRIGHT, np.random.default_rng(1))
    sigma_m = 0.0005 + 0.001 * (depth_m / 0.6) ** 2
    assert depth_sigma_m(flat(depth_m))[0, 0] == pytest.approx(sigma_m, rel=1e-5)
    assert float((noisy - depth_m).std()) == pytest.approx(sigma_m, rel=0.03)
    assert abs(float((noisy - depth_m).mean())) < 4.0 * sigma_m / 200.0


def test_a_bright_flat_surface_has_no_holes_and_a_dark_one_a_tenth() -> None:
    rng = np.random.default_rng(2)
    assert (noisy_depth(flat(0.6), BRIGHT, rng) > 0.0).all()
    assert np.mean(noisy_depth(flat(0.6), DARK, rng) == 0.0) == pytest.approx(0.10, abs=0.01)


def test_a_step_loses_three_tenths_within_two_pixels_and_nothing_beyond() -> None:
    depth_m = flat(0.6)
    depth_m[:, 100:] = 0.65
    columns = np.mean(noisy_depth(depth_m, BRIGHT, np.random.default_rng(3)) == 0.0, axis=0)
    assert np.mean(columns[98:102]) == pytest.approx(0.30, abs=0.05)
    assert (columns[:98] == 0.0).all() and (columns[102:] == 0.0).all()


def test_a_step_of_ten_millimetres_or_less_is_no_step() -> None:
    depth_m = flat(0.6)
    depth_m[:, 100:] = 0.609
    assert not near_step(depth_m).any()


def test_missing_depth_stays_missing() -> None:
    depth_m = flat(0.6)
    depth_m[:50] = 0.0
    assert (noisy_depth(depth_m, BRIGHT, np.random.default_rng(4))[:50] == 0.0).all()


def test_the_same_generator_gives_the_same_bits() -> None:
    first, second = (noisy_depth(flat(0.7), DARK, np.random.default_rng(5)) for _ in range(2))
    assert np.array_equal(first, second)


def test_colour_noise_is_mild_and_never_wraps_around() -> None:
    white = np.full((200, 200, 3), 255, np.uint8)
    assert noisy_rgb(white, np.random.default_rng(6)).min() > 235
    grain = noisy_rgb(BRIGHT, np.random.default_rng(7)).astype(float) - 128.0
    assert 1.0 < grain.std() < 4.0


def test_pose_errors_have_their_standard_deviations() -> None:
    hidden = np.array([hand_eye_error("visible", seed) for seed in range(400)])
    arrival = np.array([arrival_error("visible", seed, "center", False) for seed in range(400)])
    for poses, sigma_m, sigma_rad in (
        (hidden, 0.001, np.radians(0.1)),
        (arrival, 0.002, np.radians(0.2)),
    ):
        assert poses[:, :3, 3].std(axis=0) == pytest.approx([sigma_m] * 3, rel=0.12)
        angles = np.array([rotation_angle(T[:3, :3]) for T in poses])
        assert np.sqrt((angles**2).mean() / 3.0) == pytest.approx(sigma_rad, rel=0.12)


def test_an_arrival_error_belongs_to_seed_view_and_cover_state() -> None:
    errors = [
        arrival_error("visible", 1, "center", False),
        arrival_error("visible", 2, "center", False),
        arrival_error("visible", 1, "right", False),
        arrival_error("visible", 1, "center", True),
    ]
    assert len({error.tobytes() for error in errors}) == 4
    assert np.array_equal(errors[0], arrival_error("visible", 1, "center", False))
