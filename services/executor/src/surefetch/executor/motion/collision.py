"""Collision checks of a configuration against itself, the table and what was perceived (FCL).

Robot shapes carry the names of `ur10e`'s tables, `left finger`, `right finger`, `camera body` and
`held`; obstacles those of `obstacles`, and `table`, `seen surface`. A pair is (robot shape,
obstacle) or (robot shape, robot shape).

A scene owns FCL objects that move with every check: use it from one thread.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

import fcl
import numpy as np

from surefetch.common.geometry import Array, rigid
from surefetch.executor.motion.obstacles import VOXEL_M, Obstacles
from surefetch.executor.robot import ur10e
from surefetch.executor.robot.urdf import solid_rotation

Pair = tuple[str, str]

TABLE = "table"
SEEN = "seen surface"
HELD = "held"
FINGERS = ("left finger", "right finger")
PADDING_M = 0.005
"""Every robot shape is grown by this, half of the 10 mm between checked states of a path."""
FINGER_PADDING_SHARE = 0.4
"""Fingers work close to things, and their approach is checked in steps of 4 mm: 2 mm do."""
RECHECK_SHARE = 0.9
"""Of the padding, when the samples of a timed path are checked: they are 5 mm apart, not 10."""
TABLE_CLEARANCE_M = 0.010
FINGER_TABLE_CLEARANCE_M = 0.003
STANDS_ON_TABLE = ("base", "shoulder", "shoulder side")


@dataclass(frozen=True, eq=False)
class Held:
    """A box around the held object, fixed in the hand."""

    T_flange_object: Array
    """(4, 4), at the box's centre"""
    size_m: Array
    """(3,) full lengths"""


@dataclass(frozen=True, eq=False)
class _Shape:
    name: str
    link: str
    T_link_shape: Array
    geometry: fcl.CollisionGeometry
    half_m: Array
    """(3,) of the box around the shape, or radius, radius, half length; not padded"""
    round: bool


@dataclass(frozen=True, eq=False)
class CollisionScene:
    """The arm's surroundings at one moment. `allowing` and `holding` give changed copies."""

    T_flange_camera: Array
    obstacles: Obstacles
    held: Held | None = None
    allowed: frozenset[Pair] = frozenset()
    padding_m: float = PADDING_M

    def allowing(self, pairs: Iterable[Pair]) -> "CollisionScene":
        """The same scene where these pairs may touch."""
        return replace(self, allowed=self.allowed | frozenset(pairs))

    def holding(self, held: Held | None) -> "CollisionScene":
        """The same scene with this object in the hand."""
        return replace(self, held=held)

    def for_recheck(self) -> "CollisionScene":
        """The same scene for the samples of a timed path.

        A path that grazes the padding is not refused for a micrometre between checked states.
        """
        return replace(self, padding_m=RECHECK_SHARE * self.padding_m)

    def in_collision(self, q_rad: Array, width_m: float) -> Pair | None:
        """A colliding pair of the configuration (6,) at a finger opening, or None."""
        hit = self.first_collision(np.asarray(q_rad)[None], width_m)
        return None if hit is None else hit[1]

    def first_collision(self, q_rad: Array, width_m: float) -> tuple[int, Pair] | None:
        """The first colliding row of configurations (n, 6) and its pair; None when all are free."""
        checker = self._checker
        T_world_shape = checker.place(np.asarray(q_rad, dtype=np.float64), width_m)
        table = checker.on_table(T_world_shape)
        close = checker.close_pairs(T_world_shape)
        for i, T in enumerate(T_world_shape):
            pair = table[i] or checker.touching(T, close[i])
            if pair is not None:
                return i, pair
        return None

    @cached_property
    def _checker(self) -> "_Checker":
        return _Checker(self)


class _Checker:
    """FCL objects of one scene, and the vectorised tests around them."""

    def __init__(self, scene: CollisionScene) -> None:
        self._shapes = _robot_shapes(scene)
        names = [shape.name for shape in self._shapes]
        self._names = names
        self._link = np.array([ur10e.LINKS.index(shape.link) for shape in self._shapes])
        self._T_link_shape = np.array([shape.T_link_shape for shape in self._shapes])
        self._objects = [fcl.CollisionObject(shape.geometry) for shape in self._shapes]
        self._half = np.array([shape.half_m for shape in self._shapes])
        self._round = np.array([shape.round for shape in self._shapes])
        self._floor_m = np.array([_table_clearance(shape.name, scene) for shape in self._shapes])
        self._fingers = [names.index(name) for name in FINGERS]
        self._pairs = _self_pairs(self._shapes, scene.allowed)
        reach = np.where(self._round, np.hypot(self._half[:, 0], self._half[:, 2]), 0.0)
        reach += np.where(self._round, 0.0, np.linalg.norm(self._half, axis=1))
        reach += 2.0 * scene.padding_m
        self._near_m = reach[self._pairs[:, 0]] + reach[self._pairs[:, 1]]
        self._name_of = {id(shape.geometry): shape.name for shape in self._shapes}
        self._groups = self._group(scene)

    def _group(
        self, scene: CollisionScene
    ) -> list[tuple[fcl.DynamicAABBTreeCollisionManager, fcl.DynamicAABBTreeCollisionManager]]:
        """Robot shapes that must avoid the same obstacles, with those obstacles."""
        world = _world_objects(scene.obstacles)
        self._world = world  # the managers do not own what they hold
        self._name_of |= {id(geometry): name for name, geometry, _ in world}
        by_allowed: dict[frozenset[str], list[fcl.CollisionObject]] = {}
        for name, robot_object in zip(self._names, self._objects, strict=True):
            ignored = frozenset(b for a, b in scene.allowed if a == name)
            by_allowed.setdefault(ignored, []).append(robot_object)
        return [
            (
                _manager(robot_objects),
                _manager([thing for name, _, thing in world if name not in ignored]),
            )
            for ignored, robot_objects in by_allowed.items()
        ]

    def place(self, q_rad: Array, width_m: float) -> Array:
        """World poses (n, s, 4, 4) of all shapes."""
        for i, center in zip(self._fingers, ur10e.finger_centers(width_m), strict=True):
            self._T_link_shape[i, :3, 3] = center
        placed: Array = ur10e.link_frames(q_rad)[:, self._link] @ self._T_link_shape
        return placed

    def on_table(self, T_world_shape: Array) -> list[Pair | None]:
        """For each state the first shape that comes too near to the table plane z = 0."""
        axes = np.abs(T_world_shape[:, :, 2, :3])
        half = np.where(self._round[:, None], self._half * [0.0, 0.0, 1.0], self._half)
        drop = (axes * half).sum(axis=2)
        tilt = np.sqrt(np.clip(1.0 - axes[:, :, 2] ** 2, 0.0, None))
        drop += np.where(self._round, self._half[:, 0] * tilt, 0.0)
        low = T_world_shape[:, :, 2, 3] - drop < self._floor_m
        first = low.argmax(axis=1)
        return [
            (self._names[i], TABLE) if hit else None
            for i, hit in zip(first, low.any(axis=1), strict=True)
        ]

    def close_pairs(self, T_world_shape: Array) -> list[Array]:
        """For each state the self-pairs (k, 2) whose bounding spheres meet."""
        centers = T_world_shape[:, :, :3, 3]
        apart = centers[:, self._pairs[:, 0]] - centers[:, self._pairs[:, 1]]
        near = np.einsum("npk,npk->np", apart, apart) < self._near_m**2
        return [self._pairs[row] for row in near]

    def touching(self, T_world_shape: Array, close: Array) -> Pair | None:
        """A touching pair of one state, its shapes at (s, 4, 4)."""
        R, t = T_world_shape[:, :3, :3], T_world_shape[:, :3, 3]
        for i, robot_object in enumerate(self._objects):
            robot_object.setTransform(fcl.Transform(R[i], t[i]))
        for robot, world in self._groups:
            robot.update()
            met = fcl.CollisionData()
            robot.collide(world, met, fcl.defaultCollisionCallback)
            if met.result.is_collision:
                return self._pair_of(met.result.contacts[0])
        for i, j in close:
            if fcl.collide(self._objects[i], self._objects[j]):
                return self._names[i], self._names[j]
        return None

    def _pair_of(self, contact: fcl.Contact) -> Pair:
        a, b = self._name_of[id(contact.o1)], self._name_of[id(contact.o2)]
        return (a, b) if a in self._names else (b, a)


def _manager(
    things: Sequence[fcl.CollisionObject],
) -> fcl.DynamicAABBTreeCollisionManager:
    manager = fcl.DynamicAABBTreeCollisionManager()
    if things:
        manager.registerObjects(list(things))
    manager.setup()
    return manager


def _world_objects(
    obstacles: Obstacles,
) -> list[tuple[str, fcl.CollisionGeometry, fcl.CollisionObject]]:
    """Named FCL objects of all obstacles."""
    boxes = [(box.name, box.T_world_box, box.size_m) for box in obstacles.boxes]
    cube = np.full(3, VOXEL_M)
    boxes += [(SEEN, rigid(np.eye(3), center), cube) for center in obstacles.voxels_world_m]
    things = []
    for name, T, size in boxes:
        geometry = fcl.Box(*size)
        where = fcl.Transform(np.ascontiguousarray(T[:3, :3]), np.ascontiguousarray(T[:3, 3]))
        things.append((name, geometry, fcl.CollisionObject(geometry, where)))
    return things


def _robot_shapes(scene: CollisionScene) -> list[_Shape]:
    """Arm, gripper, fingers, camera and what is held, padded."""
    solids = [*ur10e.ARM_SHAPES, *ur10e.GRIPPER_SHAPES]
    shapes = [_shape_of(solid, solid.link, np.eye(4), scene.padding_m) for solid in solids]
    for name in FINGERS:
        finger = ur10e.Box(name, "tool0", (0.0, 0.0, 0.0), ur10e.FINGER_SIZE_M)
        padding = FINGER_PADDING_SHARE * scene.padding_m
        shapes.append(_shape_of(finger, "tool0", np.eye(4), padding))
    shapes.append(_shape_of(ur10e.CAMERA_BODY, "tool0", scene.T_flange_camera, scene.padding_m))
    if scene.held is not None:
        x, y, z = (float(v) for v in scene.held.size_m)
        held = ur10e.Box(HELD, "tool0", (0.0, 0.0, 0.0), (x, y, z))
        shapes.append(_shape_of(held, "tool0", scene.held.T_flange_object, scene.padding_m))
    return shapes


def _shape_of(solid: ur10e.Solid, link: str, T_link_solid: Array, padding_m: float) -> _Shape:
    T = solid_rotation(solid)
    T[:3, 3] = solid.center_m
    if isinstance(solid, ur10e.Box):
        half = np.asarray(solid.size_m) / 2.0
        geometry = fcl.Box(*(2.0 * (half + padding_m)))
    else:
        half = np.array([solid.radius_m, solid.radius_m, solid.length_m / 2.0])
        geometry = fcl.Cylinder(solid.radius_m + padding_m, solid.length_m + 2.0 * padding_m)
    is_round = isinstance(solid, ur10e.Cylinder)
    return _Shape(solid.name, link, T_link_solid @ T, geometry, half, is_round)


def _table_clearance(name: str, scene: CollisionScene) -> float:
    """Lowest height allowed for a shape; minus infinity where it may touch the table."""
    if name in STANDS_ON_TABLE or (name, TABLE) in scene.allowed:
        return -np.inf
    if name in FINGERS or name == HELD:
        return FINGER_TABLE_CLEARANCE_M
    return TABLE_CLEARANCE_M


_RIGID = {"tool0": "wrist_3"}
_NEVER_MEET = {("base_link", "upper_arm"), ("wrist_1", "wrist_3")}
"""Link pairs two joints apart whose envelopes never meet (sampled); tools are checked apart."""


def _self_pairs(shapes: Sequence[_Shape], allowed: frozenset[Pair]) -> Array:
    """Index pairs (p, 2) of shapes that could meet: other links, neither neighbours nor allowed."""
    pairs = [
        (i, j)
        for (i, a), (j, b) in combinations(enumerate(shapes), 2)
        if _may_meet(a, b) and not {(a.name, b.name), (b.name, a.name)} & allowed
    ]
    return np.array(pairs, dtype=np.int64)


def _may_meet(a: _Shape, b: _Shape) -> bool:
    link_a, link_b = _RIGID.get(a.link, a.link), _RIGID.get(b.link, b.link)
    apart = abs(ur10e.LINKS.index(link_a) - ur10e.LINKS.index(link_b))
    protrudes = any(shape.name in ("camera body", HELD) for shape in (a, b))
    if protrudes and apart > 0:
        return True
    return apart > 1 and (link_a, link_b) not in _NEVER_MEET and (link_b, link_a) not in _NEVER_MEET
