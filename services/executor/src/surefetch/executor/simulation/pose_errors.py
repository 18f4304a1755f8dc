"""Where the simulated arm and camera really are, against where they should be (pure).

Both errors belong to a scene's seed, so that every policy meets the same ones. The hand-eye error
stays hidden: frames carry poses from the nominal mount, pictures are taken from the true one. The
arrival error is real motion: the joints measure it.
"""

import numpy as np

from surefetch.common.geometry import Array, rigid, rotation_from_vector
from surefetch.common.streams import stream

HAND_EYE_SIGMA_M = 0.001
HAND_EYE_SIGMA_RAD = float(np.radians(0.1))
ARRIVAL_SIGMA_M = 0.002
ARRIVAL_SIGMA_RAD = float(np.radians(0.2))


def hand_eye_error(family: str, seed: int) -> Array:
    """T_nominal_true (4, 4) of the camera on its mount, one per scene; 1 mm and 0.1° an axis."""
    rng = stream(family, seed, "camera", "hand-eye")
    return _small(rng, HAND_EYE_SIGMA_M, HAND_EYE_SIGMA_RAD)


def arrival_error(family: str, seed: int, view: str, covered: bool) -> Array:
    """T_view_reached (4, 4) of the camera on arriving at a view; 2 mm and 0.2° an axis.

    One per view and cover state, and independent of the path, so that a recorded capture is the
    one that every policy gets.
    """
    rng = stream(family, seed, "camera", "arrival", view, "covered" if covered else "open")
    return _small(rng, ARRIVAL_SIGMA_M, ARRIVAL_SIGMA_RAD)


def _small(rng: np.random.Generator, sigma_m: float, sigma_rad: float) -> Array:
    turn = rotation_from_vector(rng.normal(0.0, sigma_rad, 3))
    return rigid(turn, rng.normal(0.0, sigma_m, 3))
