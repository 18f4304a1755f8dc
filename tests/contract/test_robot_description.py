"""Every reader of the generated URDF finds the robot of the tables."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import placo
import pybullet
import pytest

from surefetch.common.cell import simulated_cell
from surefetch.common.geometry import Array
from surefetch.executor.robot import kinematics, ur10e
from surefetch.executor.robot.urdf import FINGER_JOINTS, RETRACTION_JOINT, robot_urdf

FRAMES = (*ur10e.LINKS[1:], "tcp", "camera_optical", "left_finger")
Reader = Callable[[dict[str, float], str], Array]


@pytest.fixture(scope="module")
def urdf(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("robot") / "robot.urdf"
    path.write_text(robot_urdf(ur10e.camera_mount(simulated_cell().camera)), encoding="utf-8")
    return path


def placo_reader(urdf: Path) -> Reader:
    robot = placo.RobotWrapper(str(urdf), placo.Flags.ignore_collisions)

    def frame(joints: dict[str, float], name: str) -> Array:
        for joint, value in joints.items():
            robot.set_joint(joint, value)
        robot.update_kinematics()
        return np.array(robot.get_T_world_frame(name))

    return frame


def pybullet_reader(urdf: Path) -> Reader:
    client = pybullet.connect(pybullet.DIRECT)
    body = pybullet.loadURDF(str(urdf), useFixedBase=True, physicsClientId=client)
    infos = [
        pybullet.getJointInfo(body, i, physicsClientId=client)
        for i in range(pybullet.getNumJoints(body, physicsClientId=client))
    ]
    joint_of = {info[1].decode(): i for i, info in enumerate(infos)}
    link_of = {info[12].decode(): i for i, info in enumerate(infos)}

    def frame(joints: dict[str, float], name: str) -> Array:
        for joint, value in joints.items():
            pybullet.resetJointState(body, joint_of[joint], value, physicsClientId=client)
        state = pybullet.getLinkState(
            body, link_of[name], computeForwardKinematics=True, physicsClientId=client
        )
        T = np.eye(4)
        T[:3, :3] = np.reshape(pybullet.getMatrixFromQuaternion(state[5]), (3, 3))
        T[:3, 3] = state[4]
        return T

    return frame


READERS: dict[str, tuple[Callable[[Path], Reader], float]] = {
    "placo": (placo_reader, 1e-12),
    "pybullet": (pybullet_reader, 1e-6),  # single precision inside
}


@pytest.mark.parametrize("name", sorted(READERS))
def test_a_reader_of_the_urdf_finds_every_frame_where_the_tables_have_it(
    name: str, urdf: Path
) -> None:
    make, tolerance = READERS[name]
    read = make(urdf)
    rng = np.random.default_rng(1)
    for _ in range(30):
        q, width = rng.uniform(-1.0, 1.0, 6) * ur10e.Q_MAX_RAD, float(rng.uniform(0.0, 0.16))
        joints = dict(zip(ur10e.JOINTS, q, strict=True))
        joints |= dict.fromkeys(FINGER_JOINTS, width / 2.0)
        joints[RETRACTION_JOINT] = float(ur10e.retraction_m(width))
        for frame in FRAMES:
            assert np.abs(read(joints, frame) - expected(q, width, frame)).max() < tolerance, frame


def expected(q: Array, width_m: float, frame: str) -> Array:
    """The frame by the tables alone."""
    T_world_flange = ur10e.flange(q)
    if frame == "tcp":
        return T_world_flange @ ur10e.tcp(width_m)
    if frame == "camera_optical":
        return T_world_flange @ ur10e.camera_mount(simulated_cell().camera)
    if frame == "left_finger":  # its frame is the flange's, moved out and back
        moved = np.eye(4)
        moved[:3, 3] = [0.0, width_m / 2.0, -float(ur10e.retraction_m(width_m))]
        return T_world_flange @ moved
    link: Array = ur10e.link_frames(q)[ur10e.LINKS.index(frame)]
    return link


def test_placo_agrees_that_a_closed_form_answer_reaches_the_pose(urdf: Path) -> None:
    robot = placo.RobotWrapper(str(urdf), placo.Flags.ignore_collisions)
    solver = placo.KinematicsSolver(robot)
    solver.mask_fbase(True)
    for joint in (*FINGER_JOINTS, RETRACTION_JOINT):
        solver.mask_dof(joint)
    home = np.radians(simulated_cell().home.q_deg)
    for joint, value in zip(ur10e.JOINTS, home + 0.02, strict=True):
        robot.set_joint(joint, float(value))
    T = ur10e.flange(home)
    solver.add_frame_task("tool0", T).configure("flange", "soft", 1.0, 1.0)
    for _ in range(60):
        robot.update_kinematics()
        solver.solve(True)
    robot.update_kinematics()
    found = np.array([robot.get_joint(joint) for joint in ur10e.JOINTS])
    nearest = kinematics.solutions(T, found)[0]
    assert found == pytest.approx(nearest, abs=1e-4)
