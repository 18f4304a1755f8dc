"""The robot's body in the simulated world: motors, finger coupling, and the hand that holds.

Every step of simulated time goes through `SimulatedRobot.step`, so that the fingertips draw back
as they open and a held object that slips out is let go.
"""

import tempfile
from pathlib import Path

import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.settings import GripModel
from surefetch.executor.robot import ur10e
from surefetch.executor.robot.urdf import FINGER_JOINTS, RETRACTION_JOINT, robot_urdf
from surefetch.executor.simulation.pybullet_hand import HoldingHand
from surefetch.executor.simulation.pybullet_world import PybulletWorld
from surefetch.executor.simulation.quiet_pybullet import pybullet

JOINT_NAME, LINK_NAME = 1, 12
ARM_POSITION_GAIN = 0.3
FINGER_POSITION_GAIN = 0.2
FINGER_SPEED_M_S = ur10e.GRIPPER_SPEED_M_S / 2.0
PAD_FRICTION = 0.8
COUPLING_FORCE_N = 300.0
RETRACTION_FORCE_N = 2000.0
RETRACTION_STEP_M = 1e-5
"""Finer changes of the opening do not move the retraction."""


class SimulatedRobot:
    """UR10e, RG6 and camera body in a `PybulletWorld`."""

    def __init__(
        self, world: PybulletWorld, T_flange_camera: Array, q_rad: Array, grip_model: GripModel
    ) -> None:
        self._world = world
        self._client = world.client
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
        hand = self._numbers(LINK_NAME)["tool0"]
        self.hand = HoldingHand(world, (self._uid, hand, self._fingers), grip_model)
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

    def tips_world_m(self) -> Array:
        """(3,) midway between the fingertips' ends."""
        tips: Array = (self.T_world_flange() @ ur10e.tcp(self.width_m()))[:3, 3]
        return tips

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
        self.hand.after_step()

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
