"""Pictures of generated scenes from the cell's views, with the truth about every pixel.

The cover, where there is one, is off. Poses carry the errors that a run would meet.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import Cell, View
from surefetch.common.geometry import Array, intrinsics
from surefetch.common.messages import Body, BodyTruth, Container, Scene, Target
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.common.streams import stream
from surefetch.common.viewpoint import camera_pose
from surefetch.evaluation.scenes import plan as scene_plan
from surefetch.evaluation.scenes.candidate import plan_of
from surefetch.evaluation.scenes.generate import GeneratedScene
from surefetch.executor.simulation import pose_errors, sensor_noise
from surefetch.executor.simulation.pybullet_world import PybulletWorld

CLEAR_OF_WALLS_M: Final = 0.008

Bits = NDArray[np.bool_]


@dataclass(frozen=True)
class Thing:
    """What is true of one body of a picture."""

    attributes: scene_plan.Attributes
    inside: bool | None
    """None where it is neither inside nor outside by the generator's definition"""


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame and its truth."""

    layout: str
    """The scene, as family:seed"""
    view: str
    frame: RgbdFrame
    target: Target
    segmentation: NDArray[np.int16]
    """(h, w), numbered as in `messages.Truth`"""
    things: tuple[Thing, ...]
    """In the segmentation's order"""
    target_index: int | None
    """None where the table does not hold what is asked for"""
    target_share: float
    """Its visible pixels over its pixels with everything else moved away; 0 without a target"""


@dataclass(frozen=True, eq=False)
class Camera:
    """How a picture is taken."""

    view: View
    K: Array
    width: int
    height: int


def cameras(cell: Cell, scene: Scene) -> tuple[Camera, ...]:
    """The cell's own camera at each of its views."""
    spec = scene.camera
    K = intrinsics(spec.width, spec.height, spec.vertical_fov_deg)
    return tuple(Camera(view, K, spec.width, spec.height) for view in cell.views)


def pictures(
    made: GeneratedScene, cell: Cell, scene: Scene, taken_with: tuple[Camera, ...]
) -> Iterator[Picture]:
    """Settle the scene and take a picture with each camera.

    Args:
        made: what was generated.
        cell: where.
        scene: as generated, or under other conditions.
        taken_with: the cameras.
    """
    opened = _without_lid(scene)
    names = [body.name for body in scene.bodies]
    target = None if made.truth.target is None else names.index(made.truth.target)
    with PybulletWorld(opened) as world:
        world.settle()
        things = _things(opened, world.bodies_now())
        for camera in taken_with:
            yield _picture(made, cell, world, camera, things, target)


def _without_lid(scene: Scene) -> Scene:
    if scene.container is None:
        return scene
    return msgspec.structs.replace(
        scene, container=msgspec.structs.replace(scene.container, covered=False)
    )


def _picture(
    made: GeneratedScene,
    cell: Cell,
    world: PybulletWorld,
    camera: Camera,
    things: tuple[Thing, ...],
    target: int | None,
) -> Picture:
    scene, view = world.scene, camera.view
    told = camera_pose(cell, view) @ pose_errors.arrival_error(
        scene.family, scene.seed, view.name, False
    )
    true = told @ pose_errors.hand_eye_error(scene.family, scene.seed)
    shown = world.render(true, camera.K, camera.width, camera.height)
    rng = stream(scene.family, scene.seed, "perception", "image", view.name)
    frame = RgbdFrame(
        rgb=sensor_noise.noisy_rgb(shown.rgb, rng),
        depth_m=sensor_noise.noisy_depth(shown.depth_m, shown.rgb, rng),
        K=camera.K,
        T_world_camera=told,
        view=view.name,
    )
    share = 0.0
    if target is not None:
        others = {thing.name for thing in world.things} - {scene.bodies[target].name}
        alone = world.surfaces(true, camera.K, camera.width, camera.height, hidden=others)
        whole = int(np.count_nonzero(alone.segmentation == target))
        share = int(np.count_nonzero(shown.segmentation == target)) / whole if whole else 0.0
    return Picture(
        layout=f"{scene.family}:{scene.seed}",
        view=view.name,
        frame=frame,
        target=made.target,
        segmentation=shown.segmentation,
        things=things,
        target_index=target,
        target_share=share,
    )


def _things(scene: Scene, now: tuple[BodyTruth, ...]) -> tuple[Thing, ...]:
    parts = plan_of(scene.family, scene.seed).parts
    return tuple(
        Thing(part.attributes, _inside(scene.container, body, at))
        for part, body, at in zip(parts, scene.bodies, now, strict=True)
    )


def _inside(container: Container | None, body: Body, at: BodyTruth) -> bool | None:
    """By the generator's definition; the footprint is taken as a circle around the axis."""
    if container is None:
        return None
    away = np.subtract(at.position_world_m[:2], container.position_world_m[:2])
    c, s = np.cos(container.yaw_rad), np.sin(container.yaw_rad)
    own = np.abs([c * away[0] + s * away[1], c * away[1] - s * away[0]])
    half = np.asarray(container.inner_size_m) / 2.0
    if (own < half).all() and at.position_world_m[2] < container.wall_height_m:
        return True
    beyond = np.maximum(own - half - container.wall_thickness_m, 0.0)
    clear = float(np.hypot(*beyond)) - float(np.hypot(*body.size_m[:2])) / 2.0
    return False if clear >= CLEAR_OF_WALLS_M else None
