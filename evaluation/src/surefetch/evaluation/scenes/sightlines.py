"""How much of a body a camera sees, by casting rays against convex solids (pure).

A quick estimate without a renderer: good to a few hundredths, for rejecting what a segmentation
render would reject. Bodies stand upright; every solid is a set of half spaces.

Source: Cyrus and Beck, Generalized two- and three-dimensional clipping (1978).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse, project, rigid, rotation_z, transform
from surefetch.common.messages import Body, Container, Marking, Scene, Screen
from surefetch.evaluation.scenes.ground import Views
from surefetch.executor.simulation import markings, scene_bodies, scene_meshes
from surefetch.executor.simulation.scene_bodies import BoxSolid, Thing
from surefetch.executor.simulation.scene_meshes import Mesh

Mask = NDArray[np.bool_]

RAYS: Final = 260
"""About as many go through a body's frame in the image."""
PATCH_SAMPLES: Final = 90
MOST_ASLANT: Final = float(np.cos(np.radians(70.0)))
"""Cosine between a patch's normal and the sight line from which on it can be read."""
NEARER_M: Final = 0.002
BALL_PLANES: Final = 90


@dataclass(frozen=True, eq=False)
class Convex:
    """All points p with normals @ p <= offsets, in the world."""

    name: str
    normals: Array
    """(k, 3), unit, outwards"""
    offsets_m: Array
    """(k,)"""

    def hits(self, origin_m: Array, directions: Array) -> Array:
        """How far rays (n, 3) from a point travel to the solid (n,); infinity where they miss."""
        toward = directions @ self.normals.T
        room = self.offsets_m - self.normals @ origin_m
        with np.errstate(divide="ignore", invalid="ignore"):
            t = room / toward
        enter = np.where(toward < 0.0, t, -np.inf).max(axis=1)
        leave = np.where(toward > 0.0, t, np.inf).min(axis=1)
        outside = ((toward == 0.0) & (room < 0.0)).any(axis=1)
        hit = (enter <= leave) & (enter > 0.0) & ~outside
        return np.where(hit, enter, np.inf)


@dataclass(frozen=True)
class Seen:
    """What a view shows of a body, in pixels of the camera's full resolution."""

    share: float
    pixels: float


@dataclass(frozen=True)
class SeenPatch:
    """What a view shows of a marking at less than 70°."""

    pixels: float
    share: float
    """Of what it would show with everything else away; 0 when that is nothing."""


class Sightlines:
    """Bodies and what else may hide them, and the cameras that look at them."""

    def __init__(
        self,
        bodies: Sequence[Body],
        screens: Sequence[Screen],
        container: Container | None,
        views: Views,
        *,
        lid: bool,
    ) -> None:
        self._views = views
        self._bodies = {body.name: body for body in bodies}
        self._solids = [convex_of(body) for body in bodies]
        self._hull: Convex | None = None
        if container is not None:
            self._solids += _container_parts(container, lid and container.covered)
            self._hull = _hull(container)
        for screen in screens:
            self._solids += _boxes(scene_bodies.screen(screen))

    @classmethod
    def of(cls, scene: Scene, views: Views, *, lid: bool) -> "Sightlines":
        """Everything in a scene, its lid on or off."""
        return cls(scene.bodies, scene.screens, scene.container, views, lid=lid)

    def of_body(self, name: str, view: str) -> Seen:
        """Share and pixels of a body in a view."""
        body = self._bodies[name]
        eye, directions, px2 = self._rays(body, view)
        own = next(one for one in self._solids if one.name == name)
        t = own.hits(eye, directions)
        on = np.isfinite(t)
        if not on.any():
            return Seen(0.0, 0.0)
        free = on & self._clear(name, eye, directions, t)
        return Seen(float(free.sum() / on.sum()), float(free.sum() * px2))

    def over_container(self, name: str, view: str) -> float:
        """Share of a body's outline in a view whose sight lines cross the container's box."""
        body = self._bodies[name]
        if self._hull is None:
            return 0.0
        eye, directions, _ = self._rays(body, view)
        own = next(one for one in self._solids if one.name == name)
        on = np.isfinite(own.hits(eye, directions))
        over = np.isfinite(self._hull.hits(eye, directions[on]))
        return float(over.mean()) if on.any() else 0.0

    def of_patch(self, name: str, view: str) -> SeenPatch:
        """What a view shows of the patch on a body."""
        points, normals, area_m2 = patch_samples(self._bodies[name])
        eye = self._views.eye_m(view)
        towards = points - eye
        distance = np.linalg.norm(towards, axis=1)
        directions = towards / distance[:, None]
        cosine = -np.einsum("nk,nk->n", normals, directions)
        depth = transform(inverse(self._views.T_world_camera[view]), points)[:, 2]
        px = area_m2 * cosine * self._views.K[0, 0] ** 2 / depth**2
        px[cosine < MOST_ASLANT] = 0.0
        if px.sum() == 0.0:
            return SeenPatch(0.0, 0.0)
        free = self._clear(name, eye, directions, distance)
        return SeenPatch(float(px[free].sum()), float(px[free].sum() / px.sum()))

    def _clear(self, name: str, eye: Array, directions: Array, distance_m: Array) -> Mask:
        """Which rays (n,) meet no other solid first."""
        clear = np.ones(len(directions), dtype=bool)
        for one in self._solids:
            if one.name != name:
                clear &= one.hits(eye, directions) >= distance_m - NEARER_M
        return clear

    def _rays(self, body: Body, view: str) -> tuple[Array, Array, float]:
        """Eye (3,), directions (n, 3) through the body's frame in the image, pixels a ray."""
        T, K = self._views.T_world_camera[view], self._views.K
        pixels = project(K, transform(inverse(T), _corners(body)))
        low, high = pixels.min(axis=0), pixels.max(axis=0)
        step = float(np.sqrt(np.prod(high - low) / RAYS))
        u, v = (np.arange(a + step / 2.0, b, step) for a, b in zip(low, high, strict=True))
        grid = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)
        local = np.column_stack([(grid - K[:2, 2]) / np.diag(K)[:2], np.ones(len(grid))])
        directions = local @ T[:3, :3].T
        return T[:3, 3], directions / np.linalg.norm(directions, axis=1)[:, None], step**2


def patch_samples(body: Body) -> tuple[Array, Array, float]:
    """Points (n, 3) and normals (n, 3) in the world spread evenly over the patch; m² of each.

    The patch of a plain body is a dot where its near-misses are marked.
    """
    assert body.marking is not None
    marking = body.marking
    kind = "dot" if marking.kind == "plain" else marking.kind
    plain = Marking(kind=kind, face=marking.face, rgb=(0, 0, 0), coverage=marking.coverage)
    origin = Body(
        name="",
        shape=body.shape,
        size_m=body.size_m,
        rgb=(0, 0, 0),
        marking=None,
        mass_kg=0.1,
        position_world_m=(0, 0, 0),
        yaw_rad=0.0,
    )
    points, normals, area_m2 = _local_samples(origin, plain)
    x, y, z = body.position_world_m
    T = rigid(rotation_z(body.yaw_rad), np.array([x, y, z + body.size_m[2] / 2.0]))
    return transform(T, points), normals @ T[:3, :3].T, area_m2


@lru_cache(maxsize=64)
def _local_samples(body: Body, marking: Marking) -> tuple[Array, Array, float]:
    mesh = markings.patch(body, marking)
    assert mesh is not None
    return _spread(mesh)


def _spread(mesh: Mesh) -> tuple[Array, Array, float]:
    """Samples over a mesh in proportion to the area; always the same ones."""
    a, b, c = (mesh.vertices_m[mesh.triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    area = np.linalg.norm(cross, axis=1) / 2.0
    rng = np.random.default_rng(0)
    at = (np.arange(PATCH_SAMPLES) + 0.5) / PATCH_SAMPLES * area.sum()
    k = np.minimum(np.searchsorted(np.cumsum(area), at), len(area) - 1)
    r, s = np.sqrt(rng.random(PATCH_SAMPLES))[:, None], rng.random(PATCH_SAMPLES)[:, None]
    points = (1 - r) * a[k] + r * (1 - s) * b[k] + r * s * c[k]
    normals = cross[k] / (2.0 * area[k, None])
    return points, normals, float(area.sum() / PATCH_SAMPLES)


def convex_of(body: Body) -> Convex:
    """A body's solid, a ball as many planes."""
    x, y, z = body.position_world_m
    center = np.array([x, y, z + body.size_m[2] / 2.0])
    normals, offsets = _ball(body) if body.shape == "ball" else _prism(body)
    turned = normals @ rotation_z(body.yaw_rad).T
    return Convex(body.name, turned, offsets + turned @ center)


def _prism(body: Body) -> tuple[Array, Array]:
    outline = scene_meshes.outline(body.shape, body.size_m)
    if body.shape == "cylinder":
        outline = outline[::3]
    along = np.roll(outline, -1, axis=0) - outline
    level = np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(along))])
    level /= np.linalg.norm(level, axis=1)[:, None]
    sides = np.einsum("nk,nk->n", level[:, :2], outline)
    half = body.size_m[2] / 2.0
    ends = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    return np.concatenate([level, ends]), np.concatenate([sides, [half, half]])


def _ball(body: Body) -> tuple[Array, Array]:
    """Tangent planes on a Fibonacci sphere, and the flat bottom."""
    k = np.arange(BALL_PLANES) + 0.5
    z = 1.0 - 2.0 * k / BALL_PLANES
    turn = np.pi * (1.0 + np.sqrt(5.0)) * k
    level = np.sqrt(1.0 - z * z)
    normals = np.column_stack([level * np.cos(turn), level * np.sin(turn), z])
    up = scene_meshes.ball_center_m(body.size_m[0], body.size_m[2])
    offsets = body.size_m[0] / 2.0 + normals[:, 2] * up
    bottom = np.array([[0.0, 0.0, -1.0]])
    return np.concatenate([normals, bottom]), np.append(offsets, body.size_m[2] / 2.0)


def _container_parts(container: Container, lid: bool) -> list[Convex]:
    parts = _boxes(scene_bodies.container(container))
    return parts + _boxes(scene_bodies.lid(container)) if lid else parts


def _hull(container: Container) -> Convex:
    """The box around a container, from the table to the rim."""
    x, y = (v + 2.0 * container.wall_thickness_m for v in container.inner_size_m)
    h = container.wall_height_m
    thing = scene_bodies.container(container)
    return _boxes(replace(thing, solids=(BoxSolid((0.0, 0.0, h / 2.0), (x, y, h)),)))[0]


def _boxes(thing: Thing) -> list[Convex]:
    """The boxes of a thing; a knob hides next to nothing and is left out."""
    normals = np.concatenate([np.eye(3), -np.eye(3)])
    made = []
    for solid in thing.solids:
        if isinstance(solid, BoxSolid):
            half, center = np.asarray(solid.size_m) / 2.0, np.asarray(solid.center_m)
            offsets = np.concatenate([half, half]) + normals @ center
            turned = normals @ thing.T_world_thing[:3, :3].T
            made.append(Convex(thing.name, turned, offsets + turned @ thing.T_world_thing[:3, 3]))
    return made


def _corners(body: Body) -> Array:
    """The corners (8, 3) of the upright box around a body."""
    x, y, z = body.position_world_m
    half = np.asarray(body.size_m[:2]) / 2.0
    xy = half * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    level = [np.column_stack([xy, np.full(4, h)]) for h in (0.0, body.size_m[2])]
    T = rigid(rotation_z(body.yaw_rad), np.array([x, y, z]))
    return transform(T, np.concatenate(level))
