"""Colours and light of a table: eight named colours with jitter, markings that stand out (pure).

Every colour is a picture value 0 … 1, as the renderer multiplies it with the light.
"""

import colorsys
from collections.abc import Sequence
from typing import Final

import numpy as np

from surefetch.common.messages import Lighting, Rgb

COLORS: Final[dict[str, tuple[float, float, float]]] = {
    "red": (2.0, 0.86, 0.76),
    "orange": (26.0, 0.90, 0.92),
    "yellow": (52.0, 0.86, 0.92),
    "green": (130.0, 0.72, 0.55),
    "blue": (218.0, 0.82, 0.72),
    "purple": (284.0, 0.62, 0.58),
    "white": (50.0, 0.02, 0.94),
    "black": (220.0, 0.10, 0.11),
}
"""Hue in degrees, saturation and value of the colours that a sentence can name."""

NEUTRALS: Final[dict[str, tuple[float, float, float]]] = {
    "grey": (210.0, 0.03, 0.50),
    "brown": (26.0, 0.58, 0.42),
    "black": (220.0, 0.10, 0.13),
    "white": (50.0, 0.02, 0.90),
}
"""Of containers and lids."""

TABLES: Final[tuple[tuple[float, float, float], ...]] = (
    (34.0, 0.20, 0.72),
    (30.0, 0.30, 0.62),
    (215.0, 0.06, 0.66),
    (40.0, 0.10, 0.58),
)

HUE_JITTER_DEG: Final = 3.0
SHARE_JITTER: Final = 0.08
LIGHT_MARK: Final = (0.93, 0.93, 0.91)
DARK_MARK: Final = (0.07, 0.07, 0.08)


def jittered(hsv: tuple[float, float, float], rng: np.random.Generator) -> Rgb:
    """A colour near this one: hue within 3 degrees, saturation and value within 8 % of theirs."""
    hue = hsv[0] + rng.uniform(-HUE_JITTER_DEG, HUE_JITTER_DEG)
    saturation, value = (
        min(1.0, part * (1.0 + rng.uniform(-SHARE_JITTER, SHARE_JITTER))) for part in hsv[1:]
    )
    r, g, b = colorsys.hsv_to_rgb((hue % 360.0) / 360.0, saturation, value)
    return float(r), float(g), float(b)


def luminance(rgb: Rgb) -> float:
    """How bright a colour looks, 0 … 1 (Rec. 709 weights)."""
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]


def marking_rgb(body_rgb: Rgb) -> Rgb:
    """Light on a dark body, dark on a light one: whichever stands out more."""
    bright = luminance(body_rgb)
    return (
        LIGHT_MARK if luminance(LIGHT_MARK) - bright > bright - luminance(DARK_MARK) else DARK_MARK
    )


def container_colors(rng: np.random.Generator, never: str | None) -> tuple[Rgb, Rgb]:
    """Colours of container and lid, neither the target's."""
    names: Sequence[str] = [name for name in NEUTRALS if name != never]
    box, lid = (NEUTRALS[names[int(rng.integers(len(names)))]] for _ in range(2))
    return jittered(box, rng), jittered(lid, rng)


def table_rgb(rng: np.random.Generator) -> Rgb:
    """Wood or a neutral plate."""
    return jittered(TABLES[int(rng.integers(len(TABLES)))], rng)


def lighting(rng: np.random.Generator) -> Lighting:
    """A lamp above, from any side but steep enough that shadows stay short."""
    azimuth, elevation = rng.uniform(-np.pi, np.pi), np.radians(rng.uniform(45.0, 75.0))
    level = np.cos(elevation)
    return Lighting(
        direction=(
            float(level * np.cos(azimuth)),
            float(level * np.sin(azimuth)),
            float(np.sin(elevation)),
        ),
        ambient=float(rng.uniform(0.38, 0.52)),
        diffuse=float(rng.uniform(0.45, 0.65)),
        specular=float(rng.uniform(0.0, 0.08)),
    )
