"""The camera mount of the simulated cell: what it sees, and that the arm brings it there."""

import numpy as np
import pytest

from surefetch.common.cell import View, simulated_cell
from surefetch.common.geometry import Array, inverse, rigid, rotation_z, transform
from surefetch.common.viewpoint import camera_pose
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.obstacles import Obstacles
from surefetch.executor.motion.paths import Room
from surefetch.executor.robot import kinematics, ur10e, views

CELL = simulated_cell()
T_FLANGE_CAMERA = ur10e.camera_mount(CELL.camera)
BARE = CollisionScene(T_FLANGE_CAMERA, Obstacles((), np.zeros((0, 3))))
HOME = np.radians(CELL.home.q_deg)


def degrees_above_the_image(points_flange_m: Array) -> float:
    """How far (n, 3) points are past the image's upper border, the nearest of them."""
    p = transform(inverse(T_FLANGE_CAMERA), points_flange_m)
    elevation = np.degrees(np.arctan2(-p[:, 1], p[:, 2]))
    return float(elevation.min() - CELL.camera.vertical_fov_deg / 2.0)


def box_corners(center_m: Array, size_m: Array) -> Array:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners: Array = center_m + signs * size_m / 2.0
    return corners


@pytest.mark.parametrize("width_m", np.linspace(0.0, ur10e.WIDTH_MAX_M, 9))
def test_no_finger_is_in_the_image(width_m: float) -> None:
    for center in ur10e.finger_centers(width_m):
        corners = box_corners(center, np.asarray(ur10e.FINGER_SIZE_M))
        assert degrees_above_the_image(corners) > 5.0


def test_a_held_object_60_mm_below_the_tips_is_not_in_the_image() -> None:
    center = np.array([0.0, 0.0, ur10e.TIP_Z_M])
    assert degrees_above_the_image(box_corners(center, np.array([0.08, 0.08, 0.12]))) > 0.0


@pytest.mark.parametrize("view", CELL.views, ids=lambda view: view.name)
def test_the_image_is_upright_and_centred_on_the_look_at_point(view: View) -> None:
    T = camera_pose(CELL, view)
    seen = transform(inverse(T), np.asarray(CELL.look_at_m)[None])[0]
    assert seen == pytest.approx([0.0, 0.0, view.distance_m], abs=1e-12)
    assert T[2, 0] == pytest.approx(0.0, abs=1e-12)  # image rows are level
    assert -T[2, 1] > 0.0  # image-up has a part towards the sky


def test_azimuth_0_is_the_robots_side_and_positive_is_the_robots_right() -> None:
    x, y, _ = camera_pose(CELL, CELL.view("center"))[:3, 3]
    assert x < CELL.look_at_m[0] and y == pytest.approx(0.0)
    assert camera_pose(CELL, CELL.view("right"))[1, 3] < -0.3


@pytest.mark.parametrize("view", CELL.views, ids=lambda view: view.name)
def test_every_view_is_reached_from_home_by_a_free_straight_joint_move(view: View) -> None:
    room = Room(CELL, BARE, 0.10)
    found = kinematics.solutions(views.flange_pose(CELL, view), HOME)
    allowed = [q for q in found if room.refusal(q[None]) is None]
    assert room.edge_free(HOME, allowed[0])
    assert not kinematics.singularity(allowed[0]).near


@pytest.mark.parametrize("x", [0.75, 0.95, 1.15])
@pytest.mark.parametrize("y", [-0.3, 0.0, 0.3])
@pytest.mark.parametrize("yaw_deg", [0.0, 60.0, 120.0, 180.0, 240.0, 300.0])
def test_a_top_down_grasp_anywhere_in_the_working_area_is_reached(
    x: float, y: float, yaw_deg: float
) -> None:
    R = rotation_z(np.radians(yaw_deg)) @ np.diag([1.0, -1.0, -1.0])
    tcp = inverse(ur10e.tcp(0.06))
    room = Room(CELL, BARE, 0.06)
    for z in (0.008, 0.15):
        found = kinematics.solutions(rigid(R, np.array([x, y, z])) @ tcp, HOME)
        assert any(room.refusal(q[None]) is None for q in found)
