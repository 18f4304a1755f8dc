"""What the simulated camera adds to a perfect picture: depth noise, holes, grain (pure).

The model is ours, of the kind of a structured-light camera; its numbers are the cell's definition.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

SIGMA_FIXED_M = 0.0005
SIGMA_AT_REFERENCE_M = 0.001
REFERENCE_M = 0.6
STEP_M = 0.010
STEP_REACH_PX = 2
STEP_DROPOUT = 0.30
DARK_VALUE = 0.15
DARK_DROPOUT = 0.10
GRAIN = 2.0
"""Standard deviation of the colour noise, of 255."""


def depth_sigma_m(depth_m: NDArray[np.float32]) -> NDArray[np.float32]:
    """Standard deviation of depth noise: 0.5 mm + 1 mm (z / 0.6 m)²."""
    sigma: NDArray[np.float32] = SIGMA_FIXED_M + SIGMA_AT_REFERENCE_M * (depth_m / REFERENCE_M) ** 2
    return sigma


def noisy_depth(
    depth_m: NDArray[np.float32], rgb: NDArray[np.uint8], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Depth (h, w) as a sensor would give it; 0 is missing, in and out.

    Holes: 30 % within 2 px of a step of more than 10 mm, 10 % on surfaces darker than value 0.15.
    """
    noise = rng.standard_normal(depth_m.shape, np.float32)
    luck = rng.random(depth_m.shape, np.float32)
    dark = rgb.max(axis=2) < DARK_VALUE * 255.0
    p_missing = np.where(dark, DARK_DROPOUT, 0.0)
    p_missing = np.where(near_step(depth_m), np.maximum(p_missing, STEP_DROPOUT), p_missing)
    missing = (depth_m == 0.0) | (luck < p_missing)
    noisy = depth_m + noise * depth_sigma_m(depth_m)
    return np.where(missing, np.float32(0.0), noisy).astype(np.float32)


def near_step(depth_m: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Pixels (h, w) within 2 px of a step of more than 10 mm between neighbours."""
    step = np.zeros(depth_m.shape, np.bool_)
    across = np.abs(np.diff(depth_m, axis=1)) > STEP_M
    down = np.abs(np.diff(depth_m, axis=0)) > STEP_M
    step[:, 1:] |= across
    step[:, :-1] |= across
    step[1:, :] |= down
    step[:-1, :] |= down
    near: NDArray[np.bool_] = ndimage.maximum_filter(step, size=2 * STEP_REACH_PX - 1)
    return near


def noisy_rgb(rgb: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Colour (h, w, 3) with a little grain."""
    grain = rng.standard_normal(rgb.shape, np.float32) * np.float32(GRAIN)
    noisy: NDArray[np.uint8] = np.clip(np.rint(rgb + grain), 0, 255).astype(np.uint8)
    return noisy
