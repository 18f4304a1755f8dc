"""The robot's body in the simulated world: motors, finger coupling, what the fingers touch.

Every step of simulated time goes through `SimulatedRobot.step`, so that the fingertips draw back
as they open and a held object that slips out is let go.
"""

import tempfile
from pathlib import Path
from typing import Literal

import numpy as np

from surefetch.common.geometry import Array, inverse
from surefetch.executor import ur10e
from surefetch.executor.pybullet_world import PybulletWorld, matrix
from surefetch.executor.quiet_pybullet import pybullet
from surefetch.executor.urdf import FINGER_JOINTS, RETRACTION_JOINT, robot_urdf

GripModel = Literal["contact_then_hold", "friction", "attachment"]
"""How a closed hand holds: contact first and then a constraint of limited force; contact alone; or
whatever is nearest between the fingers (the paper's simulation)."""

JOINT_NAME, LINK_NAME = 1, 12
ARM_POSITION_GAIN = 0.3
FINGER_POSITION_GAIN = 0.2
FINGER_SPEED_M_S = ur10e.GRIPPER_SPEED_M_S / 2.0
PAD_FRICTION = 0.8
COUPLING_FORCE_N = 300.0
RETRACTION_FORCE_N = 2000.0
RETRACTION_STEP_M = 1e-5
"""Finer changes of the opening do not move the retraction."""
HOLD_FORCE_N = 200.0
ATTACH_FORCE_N = 10_000.0
ATTACH_REACH_M = 0.06
LEAVING_STEPS = 12
LOST_AT_M = 0.015
"""A held body that has moved this far in the hand has slipped out."""


class SimulatedRobot:
    """UR10e, RG6 and camera body in a `PybulletWorld`."""

    def __init__(
        self, world: PybulletWorld, T_flange_camera: Array, q_rad: Array, grip_model: GripModel
    ) -> None:
        self._world = world
        self._client = world.client
        self._model = grip_model
        self._held: tuple[int, int, Array] | None = None
        self._leaving: tuple[int, int] | None = None
        self._target_m = 0.0
        self._drawn_back_for_m = np.inf
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "robot.urdf"
            path.write_text(robot_urdf(T_flange_camera), encoding="utf-8")
            self._uid = pybullet.loadURDF(
                str(path), useFixedBase=True, physicsClientId=self._client
            )
            world.renderer.add_robot(str(path))
        world.before_picture = self._show
        joints = self._numbers(JOINT_NAME)
        self._arm = [joints[name] for name in ur10e.JOINTS]
        self._fingers = [joints[name] for name in FINGER_JOINTS]
        self._retraction = joints[RETRACTION_JOINT]
        self._hand = self._numbers(LINK_NAME)["tool0"]
        self._all = sorted(joints.values())
        for joint, angle in zip(self._arm, q_rad, strict=True):
            pybullet.resetJointState(self._uid, joint, angle, physicsClientId=self._client)
        self._set_friction()
        self._couple_fingers()
        self.drive(q_rad, np.zeros(6))
        self.grip(0.0, 40.0)

    def joints_rad(self) -> Array:
        """(6,) of the arm."""
        states = pybullet.getJointStates(self._uid, self._arm, physicsClientId=self._client)
        return np.array([state[0] for state in states])

    def width_m(self) -> float:
        """Opening between the pads."""
        states = pybullet.getJointStates(self._uid, self._fingers, physicsClientId=self._client)
        return float(sum(state[0] for state in states))

    def retraction_m(self) -> float:
        """How far the fingertips are drawn back."""
        state = pybullet.getJointState(self._uid, self._retraction, physicsClientId=self._client)
        return float(state[0])

    def finger_speed_m_s(self) -> float:
        """Speed of the faster finger."""
        states = pybullet.getJointStates(self._uid, self._fingers, physicsClientId=self._client)
        return float(max(abs(state[1]) for state in states))

    def T_world_flange(self) -> Array:
        """(4, 4), true."""
        return ur10e.flange(self.joints_rad())

    def drive(self, q_rad: Array, qd_rad_s: Array) -> None:
        """Aim the arm's motors, limited to the joints' torques."""
        pybullet.setJointMotorControlArray(
            self._uid,
            self._arm,
            pybullet.POSITION_CONTROL,
            targetPositions=q_rad.tolist(),
            targetVelocities=qd_rad_s.tolist(),
            forces=ur10e.TORQUE_MAX_NM.tolist(),
            positionGains=[ARM_POSITION_GAIN] * 6,
            velocityGains=[1.0] * 6,
            physicsClientId=self._client,
        )

    def grip(self, width_m: float, force_n: float) -> None:
        """Aim the finger motor; the other finger is coupled to it."""
        self._target_m = width_m
        pybullet.setJointMotorControl2(
            self._uid,
            self._fingers[0],
            pybullet.POSITION_CONTROL,
            targetPosition=width_m / 2.0,
            force=2.0 * force_n,
            positionGain=FINGER_POSITION_GAIN,
            velocityGain=1.0,
            maxVelocity=FINGER_SPEED_M_S,
            physicsClientId=self._client,
        )

    def step(self) -> None:
        """One step of simulated time."""
        width_m = self.width_m()
        if abs(width_m - self._drawn_back_for_m) > RETRACTION_STEP_M:
            self._draw_back(width_m)
        self._world.step()
        self._count_leaving()
        if self._held is not None and self._slip_m() > LOST_AT_M:
            self.release()

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

    def _draw_back(self, width_m: float) -> None:
        """Aim the retraction at what belongs to an opening."""
        self._drawn_back_for_m = width_m
        pybullet.setJointMotorControl2(
            self._uid,
            self._retraction,
            pybullet.POSITION_CONTROL,
            targetPosition=float(ur10e.retraction_m(np.clip(width_m, 0.0, ur10e.WIDTH_MAX_M))),
            force=RETRACTION_FORCE_N,
            positionGain=0.5,
            physicsClientId=self._client,
        )

    def touched_by_both(self) -> int | None:
        """The thing that both fingers touch, as an index into the world's things."""
        left, right = (
            {contact[2] for contact in self._contacts(finger)} for finger in self._fingers
        )
        for index, uid in enumerate(self._world.uids):
            if uid in left and uid in right and self._world.things[index].mass_kg > 0.0:
                return index
        return None

    def hold(self) -> int | None:
        """Hold what the fingers have closed on, as the grip model says; its index, or None."""
        index = self.touched_by_both()
        if self._model == "attachment":
            index = self._nearest_to_tips()
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

    def target_width_m(self) -> float:
        """The opening that was asked for last."""
        return self._target_m

    def _show(self) -> None:
        """Tell the renderer where the joints are."""
        states = pybullet.getJointStates(self._uid, self._all, physicsClientId=self._client)
        self._world.renderer.pose_robot([state[0] for state in states])

    def _numbers(self, name_at: int) -> dict[str, int]:
        """Joint numbers by the name at this place of PyBullet's joint info."""
        rows = [
            pybullet.getJointInfo(self._uid, joint, physicsClientId=self._client)
            for joint in range(pybullet.getNumJoints(self._uid, physicsClientId=self._client))
        ]
        return {row[name_at].decode(): row[0] for row in rows}

    def _set_friction(self) -> None:
        for finger in self._fingers:
            pybullet.changeDynamics(
                self._uid,
                finger,
                lateralFriction=PAD_FRICTION,
                spinningFriction=0.005,
                rollingFriction=1e-4,
                physicsClientId=self._client,
            )

    def _couple_fingers(self) -> None:
        """Both fingers travel alike: a gear between their joints, the motor on one of them."""
        gear = pybullet.createConstraint(
            self._uid,
            self._fingers[0],
            self._uid,
            self._fingers[1],
            jointType=pybullet.JOINT_GEAR,
            jointAxis=[0, 1, 0],
            parentFramePosition=[0, 0, 0],
            childFramePosition=[0, 0, 0],
            physicsClientId=self._client,
        )
        pybullet.changeConstraint(
            gear, gearRatio=-1, erp=0.3, maxForce=COUPLING_FORCE_N, physicsClientId=self._client
        )
        pybullet.setJointMotorControl2(
            self._uid,
            self._fingers[1],
            pybullet.VELOCITY_CONTROL,
            force=0.0,
            physicsClientId=self._client,
        )

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

    def _nearest_to_tips(self) -> int | None:
        """The loose thing whose origin is nearest to the fingertips, within reach."""
        tips = (self.T_world_flange() @ ur10e.tcp(self.width_m()))[:3, 3]
        best, nearest = None, ATTACH_REACH_M
        for index, thing in enumerate(self._world.things):
            distance = float(np.linalg.norm(self._world.placement(index)[0] - tips))
            if thing.mass_kg > 0.0 and distance < nearest:
                best, nearest = index, distance
        return best
