"""How the simulated hand holds: by contact, then by a constraint of limited force."""

from collections.abc import Sequence

import numpy as np

from surefetch.common.geometry import Array, inverse
from surefetch.common.settings import GripModel
from surefetch.executor.simulation.pybullet_world import PybulletWorld, matrix
from surefetch.executor.simulation.quiet_pybullet import pybullet

HOLD_FORCE_N = 200.0
ATTACH_FORCE_N = 10_000.0
ATTACH_REACH_M = 0.06
LEAVING_STEPS = 12
"""After a release, until the pads may touch the thing again"""
LOST_AT_M = 0.015
"""A held body that has moved this far in the hand has slipped out."""


class HoldingHand:
    """Two fingers and the link that carries them; asked after every step of the world."""

    def __init__(
        self, world: PybulletWorld, links: tuple[int, int, Sequence[int]], model: GripModel
    ) -> None:
        """`links`: the robot's body, its hand link, both finger links."""
        self._world = world
        self._client = world.client
        self._uid, self._hand, self._fingers = links
        self._model = model
        self._held: tuple[int, int, Array] | None = None
        self._leaving: tuple[int, int] | None = None

    def after_step(self) -> None:
        """Let go of what slips out, and let pads and a released thing touch again in time."""
        self._count_leaving()
        if self._held is not None and self._slip_m() > LOST_AT_M:
            self.release()

    def touched_by_both(self) -> int | None:
        """The thing that both fingers touch, as an index into the world's things."""
        left, right = (
            {contact[2] for contact in self._contacts(finger)} for finger in self._fingers
        )
        for index, uid in enumerate(self._world.uids):
            if uid in left and uid in right and self._world.things[index].mass_kg > 0.0:
                return index
        return None

    def hold(self, tips_world_m: Array) -> int | None:
        """Hold what the fingers have closed on, as the grip model says; its index, or None."""
        index = self.touched_by_both()
        if self._model == "attachment":
            index = self._nearest(tips_world_m)
        if index is not None and self._model != "friction" and self._held is None:
            self._fix(index)
        return index

    def release(self) -> None:
        """Let go of what a constraint holds.

        Until the pads have left it they do not touch it. Between a box and a cylinder that were
        squeezed together the engine finds some contacts with inverted normals, and these would
        keep the fingers from opening.
        """
        if self._held is None:
            return
        constraint, index, _ = self._held
        pybullet.removeConstraint(constraint, physicsClientId=self._client)
        self._held = None
        self._let_touch(index, False)
        self._leaving = (index, LEAVING_STEPS)

    def held(self) -> int | None:
        """The thing in the hand now, as an index into the world's things."""
        return self._held[1] if self._held is not None else self.touched_by_both()

    def _let_touch(self, index: int, may: bool) -> None:
        """Switch contacts between the fingers and a thing."""
        for finger in self._fingers:
            pybullet.setCollisionFilterPair(
                self._uid, self._world.uids[index], finger, -1, may, physicsClientId=self._client
            )

    def _count_leaving(self) -> None:
        """After a release, let pads and thing touch again in time."""
        if self._leaving is None:
            return
        index, left = self._leaving
        self._leaving = (index, left - 1) if left > 1 else None
        if self._leaving is None:
            self._let_touch(index, True)

    def _contacts(self, finger: int) -> list[tuple[int, ...]]:
        points: list[tuple[int, ...]] = pybullet.getContactPoints(
            bodyA=self._uid, linkIndexA=finger, physicsClientId=self._client
        )
        return points

    def _hand_com(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        state = pybullet.getLinkState(
            self._uid, self._hand, computeForwardKinematics=1, physicsClientId=self._client
        )
        return state[0], state[1]

    def _in_hand(self, index: int) -> Array:
        """T_hand_thing (4, 4): where a thing is against the hand's centre of mass."""
        position, quaternion = self._hand_com()
        T_world_hand = matrix((position, quaternion))  # type: ignore[arg-type]
        return inverse(T_world_hand) @ matrix(self._world.placement(index))

    def _fix(self, index: int) -> None:
        T = self._in_hand(index)
        _, turned = pybullet.invertTransform([0, 0, 0], self._hand_com()[1])
        _, quaternion = pybullet.multiplyTransforms(
            [0, 0, 0], turned, [0, 0, 0], self._world.placement(index)[1]
        )
        constraint = pybullet.createConstraint(
            self._uid,
            self._hand,
            self._world.uids[index],
            -1,
            jointType=pybullet.JOINT_FIXED,
            jointAxis=[0, 0, 0],
            parentFramePosition=T[:3, 3].tolist(),
            childFramePosition=[0, 0, 0],
            parentFrameOrientation=quaternion,
            physicsClientId=self._client,
        )
        force = ATTACH_FORCE_N if self._model == "attachment" else HOLD_FORCE_N
        pybullet.changeConstraint(constraint, maxForce=force, physicsClientId=self._client)
        self._held = (constraint, index, T)

    def _slip_m(self) -> float:
        assert self._held is not None
        _, index, T = self._held
        return float(np.linalg.norm(self._in_hand(index)[:3, 3] - T[:3, 3]))

    def _nearest(self, tips_world_m: Array) -> int | None:
        """The loose thing whose origin is nearest to the fingertips (3,), within reach."""
        best, nearest = None, ATTACH_REACH_M
        for index, thing in enumerate(self._world.things):
            distance = float(np.linalg.norm(self._world.placement(index)[0] - tips_world_m))
            if thing.mass_kg > 0.0 and distance < nearest:
                best, nearest = index, distance
        return best
