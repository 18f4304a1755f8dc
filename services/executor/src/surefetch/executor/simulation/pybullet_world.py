"""A simulated table: the physics of a scene, and pictures of it from anywhere.

    with PybulletWorld(scene) as world:
        largest_shift_m = world.settle()
        picture = world.render(T_world_camera, K, 640, 480)
        alone = world.surfaces(T_world_camera, K, 640, 480, hidden={"distractor 1", "lid"})

It works without a robot; `pybullet_devices` adds one. World = base_link, table top at z = 0.
Calls must come from one thread.
"""

from collections.abc import Callable, Collection
from types import TracebackType
from typing import Self

import numpy as np

from surefetch.common.geometry import Array, rigid
from surefetch.common.messages import BodyTruth, Scene
from surefetch.executor.simulation import scene_bodies
from surefetch.executor.simulation.pybullet_bodies import add_thing, quaternion_of
from surefetch.executor.simulation.pybullet_renderer import Picture, Placement, PybulletRenderer
from surefetch.executor.simulation.quiet_pybullet import pybullet

STEP_S = 1.0 / 240.0
SOLVER_ITERATIONS = 150
SETTLE_S = 2.0
FRICTION = 0.8


class PybulletWorld:
    """One scene under gravity. The same scene gives the same numbers and the same pixels."""

    def __init__(self, scene: Scene, *, friction: float = FRICTION, shadows: bool = True) -> None:
        self.scene = scene
        self.client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=self.client)
        pybullet.setTimeStep(STEP_S, physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            numSolverIterations=SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
            enableConeFriction=1,
            physicsClientId=self.client,
        )
        self.things = scene_bodies.things(scene)
        self.uids = [add_thing(self.client, thing, friction) for thing in self.things]
        self.before_picture: Callable[[], None] | None = None
        """Set by a robot: brings the renderer's robot up to date."""
        self.renderer = PybulletRenderer(
            self.things, scene_bodies.sheets(scene.table_rgb), scene.lighting, shadows=shadows
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End both clients."""
        pybullet.disconnect(physicsClientId=self.client)
        self.renderer.close()

    def step(self, steps: int = 1) -> None:
        """Let time pass: one step is 1/240 s."""
        for _ in range(steps):
            pybullet.stepSimulation(physicsClientId=self.client)

    def settle(self, seconds: float = SETTLE_S) -> float:
        """Let everything come to rest; how far the body that moved most has moved, in metres."""
        before = [self.placement(i) for i in self._loose()]
        self.step(round(seconds / STEP_S))
        after = [self.placement(i) for i in self._loose()]
        shifts = [
            float(np.linalg.norm(np.subtract(new[0], old[0])))
            for old, new in zip(before, after, strict=True)
        ]
        return max(shifts, default=0.0)

    def fastest_m_s(self) -> float:
        """Speed of the fastest loose thing."""
        speeds = [
            np.linalg.norm(pybullet.getBaseVelocity(self.uids[i], physicsClientId=self.client)[0])
            for i in self._loose()
        ]
        return float(max(speeds, default=0.0))

    def deepest_overlap_m(self) -> float:
        """How deep things penetrate each other where they stand now; 0 when they do not."""
        pybullet.performCollisionDetection(physicsClientId=self.client)
        contacts = pybullet.getContactPoints(physicsClientId=self.client)
        return max((-contact[8] for contact in contacts), default=0.0)

    def placement(self, index: int) -> Placement:
        """Position and quaternion of a thing's origin."""
        position, quaternion = pybullet.getBasePositionAndOrientation(
            self.uids[index], physicsClientId=self.client
        )
        return position, quaternion

    def pose(self, name: str) -> Array:
        """T_world_thing (4, 4) of a thing's origin (`scene_bodies`)."""
        return matrix(self.placement(self.index(name)))

    def put(self, name: str, T_world_thing: Array) -> None:
        """Put a thing somewhere at once, at rest."""
        uid = self.uids[self.index(name)]
        quaternion = quaternion_of(T_world_thing)
        pybullet.resetBasePositionAndOrientation(
            uid, T_world_thing[:3, 3].tolist(), quaternion, physicsClientId=self.client
        )
        pybullet.resetBaseVelocity(uid, [0, 0, 0], [0, 0, 0], physicsClientId=self.client)

    def index(self, name: str) -> int:
        """Where a thing of this name is in `things`. Raises KeyError."""
        for index, thing in enumerate(self.things):
            if thing.name == name:
                return index
        raise KeyError(name)

    def bodies_now(self) -> tuple[BodyTruth, ...]:
        """Where the scene's bodies are, in the scene's order."""
        first = len(self.things) - len(self.scene.bodies)
        return tuple(self._truth(first + k) for k in range(len(self.scene.bodies)))

    def lid_position_m(self) -> tuple[float, float, float] | None:
        """Where the lid's plate is; None in a scene without one."""
        if self.scene.container is None or not self.scene.container.covered:
            return None
        return self.placement(self.index(scene_bodies.LID))[0]

    def render(
        self,
        T_world_camera: Array,
        K: Array,
        width: int,
        height: int,
        hidden: Collection[str] = (),
    ) -> Picture:
        """A lit, noise-free picture; things named in `hidden` are left out."""
        self._place(hidden)
        return self.renderer.picture(T_world_camera, K, width, height)

    def surfaces(
        self,
        T_world_camera: Array,
        K: Array,
        width: int,
        height: int,
        hidden: Collection[str] = (),
    ) -> Picture:
        """Depth and segmentation alone, for counting visible pixels; faster than `render`."""
        self._place(hidden)
        return self.renderer.surfaces(T_world_camera, K, width, height)

    def _place(self, hidden: Collection[str]) -> None:
        if self.before_picture is not None:
            self.before_picture()
        out = {i for i, thing in enumerate(self.things) if thing.name in hidden}
        self.renderer.place([self.placement(i) for i in range(len(self.things))], out)

    def _loose(self) -> list[int]:
        return [i for i, thing in enumerate(self.things) if thing.mass_kg > 0.0]

    def _truth(self, index: int) -> BodyTruth:
        position, quaternion = self.placement(index)
        half_height = self.scene.bodies[index - len(self.things)].size_m[2] / 2.0
        up = matrix((position, quaternion))[:3, 2]
        x, y, z = (float(v) for v in np.asarray(position) - half_height * up)
        return BodyTruth(
            name=self.things[index].name,
            position_world_m=(x, y, z),
            quaternion_xyzw=quaternion,
        )


def matrix(placement: Placement) -> Array:
    """T (4, 4) of a position and a quaternion xyzw."""
    R = np.array(pybullet.getMatrixFromQuaternion(placement[1])).reshape(3, 3)
    return rigid(R, np.asarray(placement[0]))
