"""Every camera keeps the port's promises; the simulated one is exact before its noise."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from msgspec import structs
from scipy.spatial import ConvexHull
from tabletop import BLUE, RED, WHITE, body, box, move, scene

from surefetch.common.cell import simulated_cell
from surefetch.common.geometry import Array, intrinsics, inverse, project, rotation_angle, transform
from surefetch.common.messages import AskTruth, FrameId, Marking, Scene
from surefetch.common.viewpoint import camera_pose
from surefetch.executor.ports import Camera
from surefetch.executor.robot import kinematics, ur10e, views
from surefetch.executor.simulation import scene_bodies
from surefetch.executor.simulation.pybullet_cell import PybulletCell
from surefetch.executor.simulation.pybullet_devices import pybullet_devices
from surefetch.executor.simulation.pybullet_world import PybulletWorld
from surefetch.executor.simulation.scorer_questions import Simulation

NEVER: Callable[[], bool] = lambda: False  # noqa: E731
CELL = simulated_cell()
VIEWS = [view.name for view in CELL.views]
K = intrinsics(640, 480, 50.0)
CROSS = Marking(kind="cross", face="front", rgb=WHITE, coverage=0.4)
TABLE = scene(
    body("cube", marking=CROSS),
    body("cylinder", "cylinder", (0.05, 0.05, 0.08), (0.82, 0.15)),
    body("ball", "ball", (0.06, 0.06, 0.058), (0.85, -0.15)),
    container=box(covered=True),
)


@contextmanager
def pybullet_camera() -> Iterator[Camera]:
    with simulated_at("center") as simulated:
        yield pybullet_devices(simulated).camera


@contextmanager
def simulated_at(view: str, table: Scene = TABLE) -> Iterator[PybulletCell]:
    """A simulated cell, the arm driven to a view."""
    simulated = PybulletCell(CELL)
    simulated.load(table)
    drive_to(simulated, view)
    yield simulated
    simulated.close()


def drive_to(simulated: PybulletCell, view: str) -> None:
    arm = pybullet_devices(simulated).arm
    start = arm.joints_rad()
    flange = views.flange_pose(CELL, CELL.view(view))
    assert arm.follow(move(start, kinematics.solutions(flange, start)[0], 3.0), NEVER)


def T_world_camera(view: str) -> Array:
    return camera_pose(CELL, CELL.view(view))


CAMERAS = {"pybullet": pybullet_camera}


@pytest.fixture(params=sorted(CAMERAS))
def camera(request: pytest.FixtureRequest) -> Iterator[Camera]:
    with CAMERAS[request.param]() as one:
        yield one


def test_colour_and_depth_are_registered_and_typed(camera: Camera) -> None:
    image = camera.capture()
    height, width = image.depth_m.shape
    assert image.rgb.shape == (height, width, 3)
    assert image.rgb.dtype == np.uint8 and image.depth_m.dtype == np.float32
    assert image.K.shape == (3, 3)
    assert 0.0 < image.K[0, 2] < width and 0.0 < image.K[1, 2] < height


def test_missing_depth_is_zero_and_the_rest_is_plausible(camera: Camera) -> None:
    depth_m = camera.capture().depth_m
    assert np.isfinite(depth_m).all() and (depth_m >= 0.0).all()
    assert 0.5 < np.mean(depth_m > 0.0) < 1.0


def test_every_image_is_a_fresh_one(camera: Camera) -> None:
    assert not np.array_equal(camera.capture().depth_m, camera.capture().depth_m)


@pytest.mark.parametrize("view", VIEWS)
def test_corners_are_where_the_pinhole_says(view: str) -> None:
    """Silhouettes of boxes all over the image, against their projected corners.

    Turned, so that no edge runs along the pixel rows: such an edge would jump by whole pixels.
    """
    offsets = []
    T = T_world_camera(view)
    for x, y in [(0.85, -0.1), (0.9, 0.08), (1.05, -0.05), (1.1, 0.12), (0.95, 0.0), (1.0, -0.15)]:
        cube = structs.replace(body("cube", at_m=(x, y)), yaw_rad=0.35)
        with PybulletWorld(scene(cube), shadows=False) as world:
            mask = world.surfaces(T, K, 640, 480).segmentation == 0
            corners = transform(world.pose("cube"), scene_bodies.mesh_of(cube).vertices_m)
        offsets.append(
            centroid(mask) - outline_centroid(project(K, transform(inverse(T), corners)))
        )
    assert np.abs(np.mean(offsets, axis=0)).max() < 0.06
    assert np.abs(offsets).max() < 0.2


def centroid(mask: Array) -> Array:
    rows, columns = np.nonzero(mask)
    return np.array([columns.mean(), rows.mean()])


def outline_centroid(points: Array) -> Array:
    """Centroid (2,) of the convex hull of points (n, 2)."""
    hull = points[ConvexHull(points).vertices]
    after = np.roll(hull, -1, axis=0)
    cross = hull[:, 0] * after[:, 1] - after[:, 0] * hull[:, 1]
    middle: Array = ((hull + after) * cross[:, None]).sum(axis=0) / (3.0 * cross.sum())
    return middle


@pytest.mark.parametrize("size", [(640, 480), (500, 380), (972, 600)])
def test_the_table_is_as_deep_as_its_plane(size: tuple[int, int]) -> None:
    T, intrinsic = T_world_camera("center"), intrinsics(*size, 50.0)
    with PybulletWorld(TABLE) as world:
        picture = world.render(T, intrinsic, *size)
    rows, columns = np.nonzero(picture.segmentation == scene_bodies.TABLE_SEGMENT)
    ray = np.linalg.inv(intrinsic) @ np.stack([columns, rows, np.ones_like(rows)])
    heights = T[2, 3] + (T[:3, :3] @ (ray * picture.depth_m[rows, columns]))[2]
    assert np.abs(heights).max() < 1e-5


def test_the_marking_shows_its_own_colour_on_its_own_face() -> None:
    bare = scene(body("cube"))
    with PybulletWorld(scene(body("cube", marking=CROSS))) as marked, PybulletWorld(bare) as plain:
        T = T_world_camera("center")
        seen, unmarked = (w.render(T, K, 640, 480).rgb.astype(int) for w in (marked, plain))
        mask = marked.surfaces(T, K, 640, 480).segmentation == 0
    change = np.abs(seen - unmarked).max(axis=2)
    edge_of_its_shadow = (change > 0) & ~mask
    assert edge_of_its_shadow.sum() < 30 and change[~mask].max() < 40
    changed = (change > 40) & mask
    whiter = seen[changed]
    assert (whiter.max(axis=1) - whiter.min(axis=1)).max() < 20
    assert 0.10 < changed.sum() / mask.sum() < 0.40


def test_the_same_scene_gives_the_same_bits() -> None:
    runs = []
    for _ in range(2):
        with simulated_at("right") as simulated:
            image = pybullet_devices(simulated).camera.capture()
            runs.append((image, simulated.world.bodies_now(), simulated.robot.joints_rad()))
    (first, bodies, joints), (second, bodies_again, joints_again) = runs
    assert np.array_equal(first.rgb, second.rgb) and np.array_equal(first.depth_m, second.depth_m)
    assert bodies == bodies_again and np.array_equal(joints, joints_again)


def test_another_seed_gives_another_noise_on_the_same_table() -> None:
    with simulated_at("center") as one, simulated_at("center", scene(seed=4)) as other:
        first, second = (pybullet_devices(s).camera.capture() for s in (one, other))
    assert not np.array_equal(first.depth_m, second.depth_m)


def test_an_arrival_error_belongs_to_the_view_and_the_cover_not_to_the_path() -> None:
    with simulated_at("center") as simulated:
        direct = reached(simulated)
        drive_to(simulated, "close_high")
        drive_to(simulated, "center")
        again = reached(simulated)
        lid = simulated.world.pose("lid")
        lid[:3, 3] = (0.33, 0.5, 0.0025)
        simulated.world.put("lid", lid)
        drive_to(simulated, "right")
        drive_to(simulated, "center")
        opened = reached(simulated)
    assert np.abs(direct - again).max() < 2e-4
    assert np.abs(direct - opened).max() > 5e-4
    off = inverse(T_world_camera("center")) @ direct
    assert 0.0005 < np.linalg.norm(off[:3, 3]) < 0.010
    assert 0.0005 < rotation_angle(off[:3, :3]) < np.radians(1.0)


def reached(simulated: PybulletCell) -> Array:
    """T_world_camera (4, 4) as the joints tell."""
    pose: Array = ur10e.flange(simulated.robot.joints_rad()) @ ur10e.camera_mount(CELL.camera)
    return pose


def test_the_true_camera_is_off_its_nominal_mount_by_a_little() -> None:
    with simulated_at("center") as simulated:
        off = inverse(reached(simulated)) @ simulated.T_world_camera_true()
    assert 0.0 < np.linalg.norm(off[:3, 3]) < 0.005
    assert 0.0 < rotation_angle(off[:3, :3]) < np.radians(0.5)


@pytest.mark.parametrize("view", VIEWS)
def test_no_finger_is_in_the_image_at_any_opening(view: str) -> None:
    with simulated_at(view) as simulated:
        devices = pybullet_devices(simulated)
        for width_m in (0.0, 0.16):
            devices.gripper.move(width_m, 40.0, NEVER)
            devices.camera.capture()
            frame = FrameId(boot="any", counter=simulated.images)
            seen = Simulation(simulated).truth(AskTruth(frame=frame)).segmentation
            assert seen is not None
            assert scene_bodies.ARM_SEGMENT not in seen


def test_hidden_things_leave_the_picture_and_come_back() -> None:
    T = T_world_camera("center")
    with PybulletWorld(TABLE) as world:
        before = world.render(T, K, 640, 480)
        without = world.surfaces(T, K, 640, 480, hidden={"cube", "lid"}).segmentation
        after = world.render(T, K, 640, 480)
    assert 0 not in without and scene_bodies.LID_SEGMENT not in without and 1 in without
    assert np.array_equal(before.rgb, after.rgb)


def test_a_body_throws_a_shadow_away_from_the_light() -> None:
    T = T_world_camera("close_high")
    with (
        PybulletWorld(scene(body("cube"))) as lit,
        PybulletWorld(scene(body("cube")), shadows=False) as flat,
    ):
        dark, light = (w.render(T, K, 640, 480) for w in (lit, flat))
    table = dark.segmentation == scene_bodies.TABLE_SEGMENT
    shadow = table & (dark.rgb.astype(int).sum(axis=2) < light.rgb.astype(int).sum(axis=2) - 60)
    assert shadow.sum() > 500
    u, v = centroid(shadow) - centroid(dark.segmentation == 0)
    assert u > 5 and v < -5, "the light comes from the robot's left and behind"


def test_colours_are_the_scenes_own() -> None:
    T = T_world_camera("close_high")
    with PybulletWorld(scene(body("cube")), shadows=False) as world:
        picture = world.render(T, K, 640, 480)
    red = np.median(picture.rgb[picture.segmentation == 0], axis=0) / 255.0
    assert np.allclose(red / red.max(), np.array(RED) / max(RED), atol=0.06)
    assert not np.allclose(red / red.max(), np.array(BLUE) / max(BLUE), atol=0.3)
