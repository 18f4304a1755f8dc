"""How large things are: bodies by shape, containers by kind (pure)."""

from typing import Final, Literal

import numpy as np

from surefetch.common.messages import Shape, Xyz
from surefetch.executor.simulation.scene_meshes import BALL_FLAT_M

CORNER_TO_FLAT: Final = 2.0 / np.sqrt(3.0)
DENSITY_KG_M3: Final = (500.0, 1100.0)
MASS_KG: Final = (0.03, 0.40)
ContainerKind = Literal["tray", "open box", "bin", "crate"]
WALL_M: Final[dict[ContainerKind, tuple[float, float]]] = {
    "tray": (0.025, 0.040),
    "open box": (0.060, 0.090),
    "bin": (0.090, 0.120),
    "crate": (0.060, 0.090),
}
INNER_LONG_M: Final = (0.180, 0.260)
INNER_SHORT_M: Final = (0.140, 0.200)
BELOW_RIM_M: Final = 0.004
"""What lies under a lid is lower than the rim by this."""

HULL_MARGIN_M: Final = 0.001
"""The simulated contact of balls and prisms begins this far outside their surface."""


def rests_above_m(shape: Shape) -> float:
    """How high the bottom of a settled body is above what carries it."""
    return HULL_MARGIN_M if shape in ("ball", "hexagonal prism") else 0.0


def body_size(
    shape: Shape, rng: np.random.Generator, highest_m: float = 0.100, widest_m: float = 0.065
) -> Xyz:
    """Full sizes of a body that a hand can grasp, 25–100 mm high and never toppling.

    Args:
        shape: A block is at least 1.6 times as long as it is wide or high.
        rng: Draws.
        highest_m: It stays below this, for what lies under a lid; at least 25 mm.
        widest_m: Of what is not a block.
    """
    if shape in ("cube", "ball"):
        widest_m = min(widest_m, highest_m)
    across = float(rng.uniform(min(0.028, widest_m), widest_m))
    tallest = min(highest_m, 1.7 * across)
    height = float(rng.uniform(min(0.030, tallest), tallest))
    match shape:
        case "cube":
            return across, across, across
        case "ball":
            return across, across, across - BALL_FLAT_M
        case "cylinder":
            return across, across, height
        case "hexagonal prism":
            flat = min(across, 0.058)
            return flat, flat * CORNER_TO_FLAT, height
        case "block":
            return _block(rng, highest_m)


def _block(rng: np.random.Generator, highest_m: float) -> Xyz:
    """Lying along x or y, or standing where there is room."""
    widest = min(0.046, highest_m)
    short = float(rng.uniform(min(0.027, widest), widest))
    long = short * float(rng.uniform(1.6, 1.9))
    pose = int(rng.integers(3 if long < min(highest_m, 0.100) else 2))
    return ((long, short, short), (short, long, short), (short, short, long))[pose]


def wide_size(rng: np.random.Generator, shape: Shape) -> Xyz:
    """A flat disc or six-sided plate that no opening of the hand fits."""
    across, height = float(rng.uniform(0.147, 0.158)), float(rng.uniform(0.025, 0.045))
    other = across * CORNER_TO_FLAT if shape == "hexagonal prism" else across
    return across, other, height


def mass_kg(size_m: Xyz, rng: np.random.Generator) -> float:
    """By volume and a drawn density, within what the hand is made for."""
    volume = 0.8 * size_m[0] * size_m[1] * size_m[2]
    return float(np.clip(volume * rng.uniform(*DENSITY_KG_M3), *MASS_KG))


def radius_m(size_m: Xyz, shape: Shape) -> float:
    """Of the circle around a body's footprint."""
    if shape in ("cube", "block"):
        return float(np.hypot(size_m[0], size_m[1])) / 2.0
    return max(size_m[0], size_m[1]) / 2.0
