"""R3: the arm can reach what the scene asks of it, given the true positions of everything.

Inverse kinematics, joint limits, and collision-free approach, grasp and lift of the target in the
state in which it is to be grasped; all views; lifting the cover and putting it down.
"""

from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Final

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.geometry import Array, inverse, rigid, rotation_z
from surefetch.common.messages import Body, Container, Scene
from surefetch.evaluation.scenes.rejection import CLEARANCE_M
from surefetch.executor.motion.collision import CollisionScene, Held
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.obstacles import NamedBox, Obstacles
from surefetch.executor.motion.paths import Room
from surefetch.executor.motion.planner import MotionPlanner, Tool
from surefetch.executor.robot import kinematics, ur10e, views
from surefetch.executor.simulation import scene_bodies
from surefetch.executor.simulation.scene_bodies import BoxSolid, Thing

DOWN: Final = np.diag([1.0, -1.0, -1.0])
APPROACH_M: Final = 0.10
OFF_M: Final = 0.015
"""A lift is checked from here on: below, what is lifted still touches what carries it."""
TIP_BELOW_TOP_M: Final = 0.035
TIP_ABOVE_GROUND_M: Final = 0.006
ROUND_YAWS: Final = 6
VIEW_TOOL: Final = Tool(width_m=0.08)


def reach(scene: Scene, target: Body | None, cell: Cell) -> str | None:
    """What the arm cannot do in this scene, or None.

    Args:
        scene: Its container's lid is lifted if it has one.
        target: What is to be grasped, without the lid when it is inside; None in an absent scene.
        cell: The arm's cell.
    """
    hand = Hand(scene, cell)
    if not hand.sees_from_all_views():
        return "R3 view"
    container = scene.container
    if container is not None and container.covered and not hand.lifts_lid(container):
        return "R3 lid"
    if target is not None and not hand.grasps(target):
        return "R3 grasp"
    return None


class Hand:
    """The arm among the scene's true boxes."""

    def __init__(self, scene: Scene, cell: Cell) -> None:
        self._scene = scene
        self._cell = cell
        self._home = np.radians(cell.home.q_deg)
        self._planner = MotionPlanner(cell)

    def sees_from_all_views(self) -> bool:
        """Whether a configuration of every view is free, with the lid on and off."""
        room = Room(self._cell, self._around(lid=True), VIEW_TOOL.width_m)
        return all(
            any(room.refusal(q[None]) is None for q in view_configurations(self._cell, view.name))
            for view in self._cell.views
        )

    def grasps(self, target: Body) -> bool:
        """Whether some top-down grasp can be approached, closed and lifted, the lid off."""
        x, y, bottom = target.position_world_m
        tip = bottom + max(TIP_ABOVE_GROUND_M, target.size_m[2] - TIP_BELOW_TOP_M)
        around = self._around(without=target.name, lid=False)
        center = np.array([x, y, bottom + target.size_m[2] / 2.0])
        T_world_object = rigid(rotation_z(target.yaw_rad), center)
        for yaw, across in closings(target):
            width = across + 2.0 * CLEARANCE_M
            if width > ur10e.WIDTH_MAX_M:
                continue
            grasp = rigid(rotation_z(yaw) @ DOWN, np.array([x, y, tip]))
            held = _held(grasp, width, T_world_object, np.asarray(target.size_m))
            if self._up_and_down(grasp, width, around, held):
                return True
        return False

    def lifts_lid(self, container: Container) -> bool:
        """Whether some grasp of the knob lifts the lid, and sets it down at its place."""
        lid = scene_bodies.lid(container)
        knob_z = lid.T_world_thing[2, 3] + scene_bodies.LID_THICKNESS_M / 2.0
        place = self._cell.lid_place
        free = self._around(lid=False)
        width = scene_bodies.KNOB_WIDTH_M + 2.0 * CLEARANCE_M
        down_yaw = np.radians(place.yaw_deg) - container.yaw_rad
        for yaw in np.arange(2 * ROUND_YAWS) * np.pi / ROUND_YAWS:
            tip = np.array([*lid.T_world_thing[:2, 3], knob_z + TIP_ABOVE_GROUND_M])
            pick = rigid(rotation_z(yaw) @ DOWN, tip)
            held = _held_lid(pick, width, lid)
            low = scene_bodies.LID_THICKNESS_M + TIP_ABOVE_GROUND_M
            put = rigid(
                rotation_z(yaw + down_yaw) @ DOWN,
                np.asarray(place.position_m) + [0.0, 0.0, low],
            )
            if self._up_and_down(pick, width, free, held) and self._put_down(
                put, width, free, held
            ):
                return True
        return False

    def _up_and_down(
        self, grasp: Array, width_m: float, around: CollisionScene, held: Held
    ) -> bool:
        """From above to the grasp with open fingers, and up again with what is held."""
        tool = Tool(width_m=width_m)
        try:
            above = self._planner.configurations(
                _raised(grasp, APPROACH_M), self._home, around, tool
            )[0]
            down = self._planner.line(above, grasp, around, tool)
            lifted = self._planner.line(down[-1], _raised(grasp, OFF_M), around, tool)
            self._planner.line(lifted[-1], _raised(grasp, APPROACH_M), around.holding(held), tool)
        except Infeasible:
            return False
        return True

    def _put_down(self, pose: Array, width_m: float, around: CollisionScene, held: Held) -> bool:
        tool = Tool(width_m=width_m)
        carrying = around.holding(held)
        try:
            above = self._planner.configurations(
                _raised(pose, APPROACH_M), self._home, carrying, tool
            )
            self._planner.line(above[0], _raised(pose, OFF_M), carrying, tool)
        except Infeasible:
            return False
        return True

    def _around(self, *, without: str | None = None, lid: bool) -> CollisionScene:
        boxes = tuple(true_boxes(self._scene, without=without, lid=lid))
        mount = ur10e.camera_mount(self._cell.camera)
        return CollisionScene(mount, Obstacles(boxes, np.zeros((0, 3))))


@lru_cache(maxsize=16)
def view_configurations(cell: Cell, view: str) -> Array:
    """Configurations (k, 6) that put the camera at a view."""
    return kinematics.solutions(
        views.flange_pose(cell, cell.view(view)), np.radians(cell.home.q_deg)
    )


def closings(body: Body) -> Iterator[tuple[float, float]]:
    """Tool yaws and widths of top-down grasps of an upright body, the narrowest first.

    The fingers close along the tool's y; both ways round, because the camera hangs on one side.
    """
    x, y, _ = body.size_m
    match body.shape:
        case "cube" | "block":
            sides = sorted([(x, 0.0), (y, np.pi / 2.0)])
        case "hexagonal prism":
            sides = [(x, k * np.pi / 3.0) for k in range(3)]
        case _:
            sides = [(x, k * np.pi / ROUND_YAWS) for k in range(ROUND_YAWS)]
    for across, direction in sides:
        for way in (np.pi / 2.0, -np.pi / 2.0):
            yield float(body.yaw_rad + direction + way), across


def true_boxes(scene: Scene, *, without: str | None, lid: bool) -> Iterable[NamedBox]:
    """Boxes around everything that stands on the table."""
    for body in scene.bodies:
        if body.name != without:
            x, y, z = body.position_world_m
            center = np.array([x, y, z + body.size_m[2] / 2.0])
            T = rigid(rotation_z(body.yaw_rad), center)
            yield NamedBox(body.name, T, np.asarray(body.size_m))
    things = [scene_bodies.screen(one) for one in scene.screens]
    if scene.container is not None:
        things.append(scene_bodies.container(scene.container))
        if lid and scene.container.covered:
            things.append(scene_bodies.lid(scene.container))
    for thing in things:
        yield from _boxes(thing)


def _boxes(thing: Thing) -> Iterator[NamedBox]:
    """The knob of a lid, a cylinder, is left out: it is what the fingers are to close on."""
    for k, solid in enumerate(thing.solids):
        if isinstance(solid, BoxSolid):
            T = thing.T_world_thing @ rigid(np.eye(3), np.asarray(solid.center_m))
            yield NamedBox(f"{thing.name} {k}", T, np.asarray(solid.size_m))


def _raised(pose: Array, by_m: float) -> Array:
    up = pose.copy()
    up[2, 3] += by_m
    return up


def _held(grasp: Array, width_m: float, T_world_object: Array, size_m: Array) -> Held:
    T_world_flange = grasp @ inverse(ur10e.tcp(width_m))
    return Held(inverse(T_world_flange) @ T_world_object, size_m)


def _held_lid(pick: Array, width_m: float, lid: Thing) -> Held:
    plate = lid.solids[0]
    assert isinstance(plate, BoxSolid)
    return _held(pick, width_m, lid.T_world_thing, np.asarray(plate.size_m))
