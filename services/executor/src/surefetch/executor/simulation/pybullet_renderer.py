"""Pictures of things: a PyBullet client that only draws.

It has no physics and is told where everything is, so that hiding things or drawing from the lamp's
place cannot disturb the world. PyBullet's software renderer (TinyRenderer) gives depth and surface
of each pixel; `shading` makes the colours. The arm casts no shadow.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse, look_at
from surefetch.common.messages import Lighting, Rgb
from surefetch.executor.simulation import shading
from surefetch.executor.simulation.ground import Sheet, sheet_depth
from surefetch.executor.simulation.quiet_pybullet import pybullet
from surefetch.executor.simulation.scene_bodies import ARM_SEGMENT, NOTHING_SEGMENT, Thing
from surefetch.executor.simulation.scene_meshes import Mesh

Placement = tuple[tuple[float, float, float], tuple[float, float, float, float]]
"""Position in metres and quaternion xyzw, in the world."""

UID_BITS = (1 << 24) - 1
NEAR_M, FAR_M = 0.10, 4.0
LAMP_TARGET_M = (0.93, 0.0, 0.0)
LAMP_RADIUS_M = 0.60
"""Around the target; farther away there is no shadow."""
LAMP_DISTANCE_M = 2.6
LAMP_NEAR_M, LAMP_FAR_M = 1.4, 4.5
LAMP_PIXELS = 800
AWAY: Placement = ((0.0, 0.0, -50.0), (0.0, 0.0, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class Picture:
    """One noise-free image."""

    rgb: NDArray[np.uint8]
    """(h, w, 3)"""
    depth_m: NDArray[np.float32]
    """(h, w), along the optical axis; 0 where nothing is hit."""
    segmentation: NDArray[np.int16]
    """(h, w), numbered as in `messages.Truth`"""


class PybulletRenderer:
    """Draws things, and a robot if one was added, from any camera."""

    def __init__(
        self,
        things: Sequence[Thing],
        sheets: Sequence[Sheet],
        light: Lighting,
        *,
        shadows: bool = True,
    ) -> None:
        self._client = pybullet.connect(pybullet.DIRECT)
        self._sheets = tuple(sheets)
        self._light = light
        self._shadows = shadows
        self._skins: list[list[int]] = []
        self._placed: list[Placement] = []
        self._robot: int | None = None
        self._owner: dict[int, int] = {}
        self._rgb: dict[int, Rgb] = {}
        self._lamp: shading.Lamp | None = None
        for thing in things:
            self._skins.append([self._skin(thing, mesh, rgb) for mesh, rgb in thing.looks])
            self._placed.append(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))

    def close(self) -> None:
        """End the drawing client."""
        pybullet.disconnect(physicsClientId=self._client)

    def add_robot(self, urdf_path: str) -> None:
        """Also draw this robot."""
        self._robot = pybullet.loadURDF(urdf_path, useFixedBase=True, physicsClientId=self._client)
        for shape in pybullet.getVisualShapeData(self._robot, physicsClientId=self._client):
            key = self._robot | ((shape[1] + 1) << 24)
            self._owner[key] = ARM_SEGMENT
            self._rgb[key] = shape[7][:3]

    def pose_robot(self, positions: Sequence[float]) -> None:
        """Put the robot's joints, all of them in URDF order, where they are."""
        for joint, position in enumerate(positions):
            pybullet.resetJointState(self._robot, joint, position, physicsClientId=self._client)

    def place(self, placements: Sequence[Placement], hidden: Collection[int] = ()) -> None:
        """Say where every thing is; hidden ones are moved out of the picture."""
        for index, wanted in enumerate(placements):
            placement = AWAY if index in hidden else wanted
            if placement == self._placed[index]:
                continue
            self._placed[index] = placement
            self._lamp = None
            for uid in self._skins[index]:
                pybullet.resetBasePositionAndOrientation(
                    uid, *placement, physicsClientId=self._client
                )

    def picture(self, T_world_camera: Array, K: Array, width: int, height: int) -> Picture:
        """Colour, depth and surface, lit and shadowed."""
        depth_m, segmentation, albedo = self._seen(T_world_camera, K, width, height)
        lamp = self._lamp_now() if self._shadows else None
        rgb = shading.lit(albedo, depth_m, K, T_world_camera, self._light, lamp)
        return Picture(rgb, depth_m, segmentation)

    def surfaces(self, T_world_camera: Array, K: Array, width: int, height: int) -> Picture:
        """Depth and surface alone, for counting pixels; `rgb` is black."""
        depth_m, segmentation, _ = self._seen(T_world_camera, K, width, height)
        return Picture(np.zeros((height, width, 3), np.uint8), depth_m, segmentation)

    def _seen(
        self, T_world_camera: Array, K: Array, width: int, height: int
    ) -> tuple[NDArray[np.float32], NDArray[np.int16], NDArray[np.float32]]:
        """Depth, segmentation and albedo of things, before table and floor."""
        depth_m, keys = self._raster(T_world_camera, K, width, height, NEAR_M, FAR_M)
        segmentation, albedo = self._look_up(keys)
        for sheet in self._sheets:
            behind = sheet_depth(sheet, T_world_camera, K, width, height)
            shown = (behind < FAR_M) & ((depth_m == 0.0) | (behind < depth_m))
            depth_m[shown] = behind[shown]
            segmentation[shown] = sheet.segment
            albedo[shown] = sheet.rgb
        return depth_m, segmentation, albedo

    def _look_up(self, keys: NDArray[np.int32]) -> tuple[NDArray[np.int16], NDArray[np.float32]]:
        """Segmentation (h, w) and albedo (h, w, 3) of the surface keys."""
        n = 1 + max(key & UID_BITS for key in self._owner)
        links = 1 + max(key >> 24 for key in self._owner)
        owner = np.full(n * links + 1, NOTHING_SEGMENT, np.int16)
        rgb = np.zeros((n * links + 1, 3), np.float32)
        for key, segment in self._owner.items():
            owner[(key & UID_BITS) + n * (key >> 24)] = segment
            rgb[(key & UID_BITS) + n * (key >> 24)] = self._rgb[key]
        where = np.where(keys < 0, n * links, (keys & UID_BITS) + n * (keys >> 24))
        return owner[where], rgb[where]

    def _skin(self, thing: Thing, mesh: Mesh, rgb: Rgb) -> int:
        shape = pybullet.createVisualShape(
            pybullet.GEOM_MESH,
            vertices=mesh.vertices_m.tolist(),
            indices=mesh.triangles.ravel().tolist(),
            physicsClientId=self._client,
        )
        uid: int = pybullet.createMultiBody(0.0, -1, shape, physicsClientId=self._client)
        self._owner[uid], self._rgb[uid] = thing.segment, rgb
        return uid

    def _lamp_now(self) -> shading.Lamp:
        """The lamp's depth image, drawn again after something has moved."""
        if self._lamp is None:
            towards = np.asarray(self._light.direction) / np.linalg.norm(self._light.direction)
            target = np.asarray(LAMP_TARGET_M)
            eye = target + LAMP_DISTANCE_M * towards
            T_world_lamp = look_at(eye, target, np.array([1.0, 0.0, 0.01]))
            focal = LAMP_PIXELS / 2.0 * LAMP_DISTANCE_M / LAMP_RADIUS_M
            middle = (LAMP_PIXELS - 1) / 2.0
            K = np.array([[focal, 0.0, middle], [0.0, focal, middle], [0.0, 0.0, 1.0]])
            self._move_robot(AWAY)
            depth_m, _ = self._raster(
                T_world_lamp, K, LAMP_PIXELS, LAMP_PIXELS, LAMP_NEAR_M, LAMP_FAR_M
            )
            self._move_robot(((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
            self._lamp = shading.Lamp(depth_m, K, T_world_lamp)
        return self._lamp

    def _move_robot(self, placement: Placement) -> None:
        if self._robot is not None:
            pybullet.resetBasePositionAndOrientation(
                self._robot, *placement, physicsClientId=self._client
            )

    def _raster(
        self, T_world_camera: Array, K: Array, width: int, height: int, near_m: float, far_m: float
    ) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
        """Depth (h, w) in metres and the drawing client's surface key of each pixel."""
        _, _, _, buffer, keys = pybullet.getCameraImage(
            width,
            height,
            view_matrix(T_world_camera),
            projection_matrix(K, width, height, near_m, far_m),
            shadow=0,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_SEGMENTATION_MASK_OBJECT_AND_LINKINDEX,
            physicsClientId=self._client,
        )
        b = np.asarray(buffer, np.float64).reshape(height, width)
        depth_m = far_m * near_m / (far_m - (far_m - near_m) * b)
        depth_m[b >= 1.0] = 0.0
        return depth_m.astype(np.float32), np.asarray(keys, np.int32).reshape(height, width)


def view_matrix(T_world_camera: Array) -> list[float]:
    """OpenGL's view matrix of an OpenCV camera pose, column by column."""
    V = np.diag([1.0, -1.0, -1.0, 1.0]) @ inverse(T_world_camera)
    return [float(v) for v in V.T.ravel()]


def projection_matrix(
    K: Array, width: int, height: int, near_m: float, far_m: float
) -> list[float]:
    """OpenGL's projection of pinhole intrinsics, column by column, as TinyRenderer needs it.

    Its pixel rows are off by one against OpenGL's; hence the + 1.
    """
    P = np.zeros((4, 4))
    P[0, 0], P[1, 1] = 2.0 * K[0, 0] / width, 2.0 * K[1, 1] / height
    P[0, 2] = 1.0 - 2.0 * K[0, 2] / width
    P[1, 2] = 2.0 * (K[1, 2] + 1.0) / height - 1.0
    P[2, 2] = -(far_m + near_m) / (far_m - near_m)
    P[2, 3] = -2.0 * far_m * near_m / (far_m - near_m)
    P[3, 2] = -1.0
    return [float(v) for v in P.T.ravel()]
