"""A scene as solids to touch and meshes to see (pure).

Every thing has a name, a pose, a list of convex solids for contact and a list of coloured meshes
for pictures. A body's origin is the centre of its bounding box; a container's is the centre of its
bottom; a lid's the centre of its plate; a screen's the centre of its bottom.
"""

from dataclasses import dataclass

import numpy as np

from surefetch.common.geometry import Array, rigid, rotation_z
from surefetch.common.messages import Body, Container, Rgb, Scene, Screen
from surefetch.executor.simulation import markings, scene_meshes
from surefetch.executor.simulation.ground import Sheet
from surefetch.executor.simulation.scene_meshes import Mesh

TABLE = "table"
CONTAINER = "container"
LID = "lid"
SCREEN = "screen"
FLOOR = "floor"

NOTHING_SEGMENT = -1
CONTAINER_SEGMENT = -2
LID_SEGMENT = -3
SCREEN_SEGMENT = -4
TABLE_SEGMENT = -5
ARM_SEGMENT = -6
"""What a segmentation calls the pixels of everything that is no body, as `messages.Truth` says."""

TABLE_MIN_M = (-0.45, -1.05)
TABLE_MAX_M = (1.75, 1.05)
SLAB_M = 0.04
FLOOR_MIN_M = (-2.5, -4.5)
FLOOR_MAX_M = (6.5, 4.5)
FLOOR_Z_M = -0.75
FLOOR_RGB = (0.42, 0.43, 0.45)
SCREEN_RGB = (0.50, 0.50, 0.50)

LID_THICKNESS_M = 0.005
LID_OVERHANG_M = 0.006
LID_MASS_KG = 0.15
KNOB_WIDTH_M = 0.030
KNOB_HEIGHT_M = 0.030
KNOB_SHADE = 0.55
"""The knob is the lid's colour, darker by this factor."""

ROLLING_FRICTION = 1e-4
BALL_ROLLING_FRICTION = 2e-3


@dataclass(frozen=True)
class BoxSolid:
    """A box, full sizes, parallel to the thing's axes."""

    center_m: tuple[float, float, float]
    size_m: tuple[float, float, float]


@dataclass(frozen=True)
class CylinderSolid:
    """An upright cylinder."""

    center_m: tuple[float, float, float]
    radius_m: float
    height_m: float


@dataclass(frozen=True, eq=False)
class HullSolid:
    """The convex hull of points (n, 3)."""

    vertices_m: Array


Solid = BoxSolid | CylinderSolid | HullSolid


@dataclass(frozen=True, eq=False)
class Thing:
    """One rigid thing on the table; mass 0 is fixed."""

    name: str
    mass_kg: float
    T_world_thing: Array
    solids: tuple[Solid, ...]
    looks: tuple[tuple[Mesh, Rgb], ...]
    segment: int
    """What a segmentation calls its pixels: the index of the scene's body, or one of the above."""
    rolling_friction: float = ROLLING_FRICTION


def things(scene: Scene) -> tuple[Thing, ...]:
    """Everything in the scene in a fixed order: floor, table, container, lid, screens, bodies."""
    listed = [floor(), table()]
    if scene.container is not None:
        listed.append(container(scene.container))
        if scene.container.covered:
            listed.append(lid(scene.container))
    listed += [screen(wall) for wall in scene.screens]
    return (*listed, *(body(one, k) for k, one in enumerate(scene.bodies)))


def table() -> Thing:
    """The table; its top is z = 0. Seen as a sheet."""
    (x0, y0), (x1, y1) = TABLE_MIN_M, TABLE_MAX_M
    size = (x1 - x0, y1 - y0, SLAB_M)
    center = ((x0 + x1) / 2.0, (y0 + y1) / 2.0, -SLAB_M / 2.0)
    return Thing(TABLE, 0.0, np.eye(4), (BoxSolid(center, size),), (), TABLE_SEGMENT)


def floor() -> Thing:
    """The floor of the room, far below. Seen as a sheet."""
    (x0, y0), (x1, y1) = FLOOR_MIN_M, FLOOR_MAX_M
    size = (x1 - x0, y1 - y0, SLAB_M)
    center = ((x0 + x1) / 2.0, (y0 + y1) / 2.0, FLOOR_Z_M - SLAB_M / 2.0)
    return Thing(FLOOR, 0.0, np.eye(4), (BoxSolid(center, size),), (), NOTHING_SEGMENT)


def sheets(table_rgb: Rgb) -> tuple[Sheet, ...]:
    """The level surfaces below everything, from the top down."""
    return (
        Sheet(0.0, TABLE_MIN_M, TABLE_MAX_M, table_rgb, TABLE_SEGMENT),
        Sheet(FLOOR_Z_M, FLOOR_MIN_M, FLOOR_MAX_M, FLOOR_RGB, NOTHING_SEGMENT),
    )


def body(one: Body, index: int) -> Thing:
    """A loose object, the scene's `index`-th: its own colour, and its marking's patch."""
    x, y, z = one.size_m
    looks: list[tuple[Mesh, Rgb]] = [(mesh_of(one), one.rgb)]
    if one.marking is not None:
        patch = markings.patch(one, one.marking)
        if patch is not None:
            looks.append((patch, one.marking.rgb))
    rolling = BALL_ROLLING_FRICTION if one.shape == "ball" else ROLLING_FRICTION
    bottom_x, bottom_y, bottom_z = one.position_world_m
    T = rigid(rotation_z(one.yaw_rad), np.array([bottom_x, bottom_y, bottom_z + z / 2.0]))
    return Thing(one.name, one.mass_kg, T, (_solid_of(one),), tuple(looks), index, rolling)


def mesh_of(one: Body) -> Mesh:
    """The body's surface, without its marking."""
    if one.shape == "ball":
        return scene_meshes.ball(one.size_m[0], one.size_m[2])
    return scene_meshes.prism(scene_meshes.outline(one.shape, one.size_m), one.size_m[2])


def _solid_of(one: Body) -> Solid:
    if one.shape in ("cube", "block"):
        return BoxSolid((0.0, 0.0, 0.0), one.size_m)
    if one.shape == "cylinder":
        return CylinderSolid((0.0, 0.0, 0.0), one.size_m[0] / 2.0, one.size_m[2])
    return HullSolid(mesh_of(one).vertices_m)


def container(one: Container) -> Thing:
    """Floor and four walls."""
    x, y = one.inner_size_m
    t, h, f = one.wall_thickness_m, one.wall_height_m, one.floor_thickness_m
    parts = (
        BoxSolid((0.0, 0.0, f / 2.0), (x + 2.0 * t, y + 2.0 * t, f)),
        *(BoxSolid((s * (x + t) / 2.0, 0.0, h / 2.0), (t, y + 2.0 * t, h)) for s in (-1.0, 1.0)),
        *(BoxSolid((0.0, s * (y + t) / 2.0, h / 2.0), (x, t, h)) for s in (-1.0, 1.0)),
    )
    mesh = scene_meshes.merged([scene_meshes.box(part.size_m, part.center_m) for part in parts])
    T = rigid(rotation_z(one.yaw_rad), np.asarray(one.position_world_m))
    return Thing(CONTAINER, 0.0, T, parts, ((mesh, one.rgb),), CONTAINER_SEGMENT)


def lid(one: Container) -> Thing:
    """A loose plate with a knob, lying on the rim and a little wider than the walls."""
    x, y = (v + 2.0 * (one.wall_thickness_m + LID_OVERHANG_M) for v in one.inner_size_m)
    knob_z = (LID_THICKNESS_M + KNOB_HEIGHT_M) / 2.0
    plate = BoxSolid((0.0, 0.0, 0.0), (x, y, LID_THICKNESS_M))
    knob = CylinderSolid((0.0, 0.0, knob_z), KNOB_WIDTH_M / 2.0, KNOB_HEIGHT_M)
    knob_mesh = scene_meshes.prism(
        scene_meshes.outline("cylinder", (KNOB_WIDTH_M, KNOB_WIDTH_M)), KNOB_HEIGHT_M
    )
    knob_mesh = Mesh(knob_mesh.vertices_m + [0.0, 0.0, knob_z], knob_mesh.triangles)
    r, g, b = (KNOB_SHADE * v for v in one.lid_rgb)
    looks = ((scene_meshes.box(plate.size_m), one.lid_rgb), (knob_mesh, (r, g, b)))
    center = np.asarray(one.position_world_m) + [0.0, 0.0, one.wall_height_m + LID_THICKNESS_M / 2]
    return Thing(
        LID, LID_MASS_KG, rigid(rotation_z(one.yaw_rad), center), (plate, knob), looks, LID_SEGMENT
    )


def screen(one: Screen) -> Thing:
    """An upright wall, fixed."""
    part = BoxSolid((0.0, 0.0, one.size_m[2] / 2.0), one.size_m)
    T = rigid(rotation_z(one.yaw_rad), np.asarray(one.position_world_m))
    mesh = scene_meshes.box(part.size_m, part.center_m)
    return Thing(SCREEN, 0.0, T, (part,), ((mesh, SCREEN_RGB),), SCREEN_SEGMENT)
