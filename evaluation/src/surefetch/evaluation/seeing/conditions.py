"""Lights, tables and cameras outside what the generator draws: to see how far perception reaches.

Pure. The generator's lamp stands 45 to 75 degrees high and its tables are warm or grey; here lamps
are low, dim or glaring, tables dark, coloured or white, and cameras of other sizes and lenses.
"""

from typing import Final

import msgspec
import numpy as np

from surefetch.common.cell import View
from surefetch.common.geometry import intrinsics
from surefetch.common.messages import Lighting, Rgb, Scene
from surefetch.common.streams import stream
from surefetch.evaluation.seeing.images import Camera

SIZES: Final = ((480, 360), (848, 480), (800, 600), (1024, 768), (1280, 720))
TABLES: Final[tuple[Rgb, ...]] = (
    (0.20, 0.22, 0.25),
    (0.16, 0.33, 0.24),
    (0.25, 0.33, 0.52),
    (0.48, 0.20, 0.18),
    (0.93, 0.93, 0.91),
)
FOV_DEG: Final = (40.0, 60.0)
OFF_CENTER_SHARE: Final = 0.03
"""The optical axis misses the image's middle by up to this share of its size."""


def unseen(scene: Scene) -> Scene:
    """The scene under a light and on a table that the generator does not draw."""
    rng = stream(scene.family, scene.seed, "perception", "conditions")
    azimuth, elevation = rng.uniform(-np.pi, np.pi), np.radians(rng.uniform(25.0, 45.0))
    level = float(np.cos(elevation))
    ambient = float(rng.uniform(0.25, 0.65))
    light = Lighting(
        direction=(
            level * float(np.cos(azimuth)),
            level * float(np.sin(azimuth)),
            float(np.sin(elevation)),
        ),
        ambient=ambient,
        diffuse=float(rng.uniform(0.7, 1.2)) - ambient,
        specular=float(rng.uniform(0.05, 0.20)),
    )
    table = TABLES[int(rng.integers(len(TABLES)))]
    return msgspec.structs.replace(scene, lighting=light, table_rgb=table)


def unseen_camera(scene: Scene, view: View) -> Camera:
    """Another image size and lens, the optical axis off the middle."""
    rng = stream(scene.family, scene.seed, "perception", "camera", view.name)
    width, height = SIZES[int(rng.integers(len(SIZES)))]
    K = intrinsics(width, height, float(rng.uniform(*FOV_DEG)))
    K[:2, 2] += rng.uniform(-OFF_CENTER_SHARE, OFF_CENTER_SHARE, 2) * [width, height]
    return Camera(view, K, width, height)
