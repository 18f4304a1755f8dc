"""Tables for grasp trials: one object alone, or one with a neighbour or a wall within 40 mm.

Sizes, masses and places are those of the vocabulary; the first body is the one to fetch.
"""

from dataclasses import dataclass

import numpy as np
from tabletop import LIGHTING

from surefetch.common.geometry import Array, rotation_z
from surefetch.common.messages import Body, Container, Rgb, Scene, Shape
from surefetch.executor.simulation.scene_meshes import outline

AREA_M = (np.array([0.75, -0.30]), np.array([1.15, 0.30]))
CLOSE_M = (0.008, 0.040)
"""Gap to the neighbour or to the nearest wall of the container, from nearest to farthest"""
COLORS: tuple[Rgb, ...] = (
    (0.78, 0.12, 0.10),
    (0.88, 0.42, 0.08),
    (0.90, 0.80, 0.10),
    (0.10, 0.50, 0.20),
    (0.12, 0.28, 0.75),
    (0.42, 0.16, 0.55),
    (0.95, 0.95, 0.93),
    (0.08, 0.08, 0.08),
)
KINDS = {
    "tray": (0.025, 0.04),
    "open box": (0.06, 0.09),
    "bin": (0.09, 0.12),
    "crate": (0.06, 0.09),
}
SHAPES: tuple[Shape, ...] = ("cube", "block", "cylinder", "ball", "hexagonal prism")
FLOOR_M = WALL_M = 0.005


@dataclass(frozen=True)
class Trial:
    """A scene whose first body is to be fetched."""

    scene: Scene
    where: str
    """`table`, `neighbour`, or the kind of the container"""

    @property
    def target(self) -> Body:
        """What to fetch."""
        return self.scene.bodies[0]


def single(seed: int) -> Trial:
    """One object alone on the table."""
    rng = np.random.default_rng([11, seed])
    return Trial(_scene(seed, (_body("target", rng, rng.uniform(*AREA_M)),)), "table")


def crowded(seed: int) -> Trial:
    """One object beside another one, or near to a wall of the container that it stands in."""
    rng = np.random.default_rng([12, seed])
    make = _beside_neighbour if rng.random() < 0.5 else _near_wall
    while (trial := make(seed, rng)) is None:
        pass
    return trial


def _beside_neighbour(seed: int, rng: np.random.Generator) -> Trial | None:
    target = _body("target", rng, rng.uniform(*AREA_M))
    place = np.asarray(target.position_world_m[:2]) + rng.uniform(-0.13, 0.13, 2)
    neighbour = _body("neighbour", rng, place)
    if not CLOSE_M[0] <= _gap_m(target, neighbour) <= CLOSE_M[1]:
        return None
    return Trial(_scene(seed, (target, neighbour)), "neighbour")


def _near_wall(seed: int, rng: np.random.Generator) -> Trial | None:
    kind = str(rng.choice(list(KINDS)))
    inner = rng.permutation([rng.uniform(0.18, 0.26), rng.uniform(0.14, 0.20)])
    center, yaw = rng.uniform([0.85, -0.2], [1.05, 0.2]), float(rng.uniform(-0.6, 0.6))
    height = float(rng.uniform(*KINDS[kind]))
    where = rotation_z(yaw)[:2, :2] @ (rng.uniform(-0.5, 0.5, 2) * inner) + center
    target = _body("target", rng, where, FLOOR_M)
    own = (_outline(target) - center) @ rotation_z(yaw)[:2, :2]
    nearest_m = float((inner / 2.0 - np.abs(own)).min())
    if not CLOSE_M[0] <= nearest_m <= CLOSE_M[1]:
        return None
    if target.size_m[2] + FLOOR_M > height and kind != "tray":
        return None
    return Trial(_scene(seed, (target,), _container(kind, inner, center, yaw, height)), kind)


def _container(kind: str, inner_m: Array, center_m: Array, yaw: float, height: float) -> Container:
    return Container(
        kind=kind,  # type: ignore[arg-type]
        inner_size_m=(float(inner_m[0]), float(inner_m[1])),
        wall_height_m=height,
        wall_thickness_m=WALL_M,
        floor_thickness_m=FLOOR_M,
        rgb=(0.45, 0.30, 0.18),
        position_world_m=(float(center_m[0]), float(center_m[1]), 0.0),
        yaw_rad=yaw,
        covered=False,
        lid_rgb=(0.60, 0.60, 0.62),
    )


def _scene(seed: int, bodies: tuple[Body, ...], container: Container | None = None) -> Scene:
    return Scene(
        family="grasp trial",
        seed=seed,
        generator_version=1,
        bodies=bodies,
        container=container,
        screens=(),
        lighting=LIGHTING,
        table_rgb=(0.72, 0.66, 0.58),
    )


def _body(name: str, rng: np.random.Generator, at_m: Array, on_m: float = 0.0) -> Body:
    shape = SHAPES[rng.integers(len(SHAPES))]
    return Body(
        name=name,
        shape=shape,
        size_m=_size(shape, rng),
        rgb=COLORS[rng.integers(len(COLORS))],
        marking=None,
        mass_kg=float(rng.uniform(0.03, 0.40)),
        position_world_m=(float(at_m[0]), float(at_m[1]), on_m),
        yaw_rad=float(rng.uniform(-np.pi, np.pi)),
    )


def _size(shape: Shape, rng: np.random.Generator) -> tuple[float, float, float]:
    width, height = float(rng.uniform(0.025, 0.08)), float(rng.uniform(0.025, 0.10))
    if shape == "cube":
        return width, width, width
    if shape == "block":
        return min(width * float(rng.uniform(1.6, 2.2)), 0.14), width, height
    if shape == "ball":
        width = max(width, 0.027)
        return width, width, width - 0.002
    return width, width if shape == "cylinder" else width / float(np.cos(np.pi / 6.0)), height


def _outline(one: Body) -> Array:
    """Points (n, 2) along the footprint, in the world."""
    corners = outline("cylinder" if one.shape == "ball" else one.shape, one.size_m)
    steps = np.linspace(0.0, 1.0, 12, endpoint=False)[:, None]
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    own = np.concatenate([a + (b - a) * steps for a, b in sides])
    placed: Array = own @ rotation_z(one.yaw_rad)[:2, :2].T + np.asarray(one.position_world_m[:2])
    return placed


def _gap_m(a: Body, b: Body) -> float:
    """Between two footprints; negative when one is over the other."""
    apart = np.linalg.norm(_outline(a)[:, None] - _outline(b)[None], axis=2).min()
    centers = np.subtract(a.position_world_m[:2], b.position_world_m[:2])
    overlap = np.linalg.norm(centers) < (min(a.size_m[:2]) + min(b.size_m[:2])) / 2.0
    return -1.0 if overlap else float(apart)
