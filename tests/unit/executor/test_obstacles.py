import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs

from surefetch.common.geometry import Array, inverse, rotation_z, transform
from surefetch.common.messages import Box3d, ContainerReading, Estimate, Lid, Mask, Track
from surefetch.executor.motion.obstacles import VOXEL_M, container_boxes, obstacles_of

CONTAINER_SIZE_M = (0.22, 0.18, 0.08)


def container(yaw_rad: float, lid: Lid | None = None) -> ContainerReading:
    return ContainerReading(
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        mask=Mask(height=1, width=1, counts=(1,)),
        outer=Box3d(center_world_m=(0.95, 0.1, 0.04), size_m=CONTAINER_SIZE_M, yaw_rad=yaw_rad),
        inner_size_m=(0.20, 0.16),
        floor_z_m=0.005,
        rim_z_m=0.08,
        complete=True,
        lid=lid,
    )


def track(i: int, x: float) -> Track:
    solid = Box3d(center_world_m=(x, 0.0, 0.03), size_m=(0.04, 0.04, 0.06), yaw_rad=0.3)
    return Track(
        id=i,
        center_world_m=solid.center_world_m,
        solid=solid,
        points_world_m=np.zeros((0, 3), np.float32),
        hist=None,
        n_observations=1,
        y0=None,
        last_detection="d",
        last_step=0,
    )


def estimate(reading: ContainerReading | None = None, points: Array | None = None) -> Estimate:
    seen = np.zeros((0, 3)) if points is None else points
    return Estimate(
        tracks=(track(0, 0.8), track(1, 1.0)),
        container=reading,
        cover="open",
        obstacles=(),
        obstacle_points_world_m=seen.astype(np.float32),
    )


@given(st.floats(-3.0, 3.0))
def test_the_inside_of_a_container_is_free_and_its_walls_are_not(yaw_rad: float) -> None:
    boxes = container_boxes(container(yaw_rad))

    def solid_at(x: float, y: float, z: float) -> bool:
        center = np.array([0.95, 0.1, 0.0])
        p = center + rotation_z(yaw_rad) @ np.array([x, y, z])
        local = [np.abs(transform(inverse(box.T_world_box), p[None])[0]) for box in boxes]
        return any((q <= b.size_m / 2.0).all() for q, b in zip(local, boxes, strict=True))

    assert not solid_at(0.0, 0.0, 0.04)
    assert not solid_at(0.09, -0.07, 0.01)
    assert solid_at(0.105, 0.0, 0.04) and solid_at(-0.105, 0.0, 0.04)
    assert solid_at(0.0, 0.085, 0.075) and solid_at(0.0, -0.085, 0.075)
    assert solid_at(0.0, 0.0, 0.003)
    assert not solid_at(0.0, 0.0, 0.1)


def test_an_ignored_track_is_no_obstacle_and_its_surface_neither() -> None:
    on_0, on_1 = np.array([0.8, 0.0, 0.06]), np.array([1.0, 0.0, 0.06])
    alone = np.array([0.9, 0.2, 0.055])
    noise = np.array([1.1, 0.2, 0.003])  # the table's own surface is no obstacle
    given_points = np.array([on_0, on_1, alone, noise])
    world = obstacles_of(estimate(points=given_points), ignore_tracks=(1,))
    assert [box.name for box in world.boxes] == ["track 0"]
    assert world.voxels_world_m == pytest.approx(alone[None], abs=VOXEL_M)


def test_the_lid_is_an_obstacle_until_it_is_to_be_taken() -> None:
    plate = Box3d(center_world_m=(0.95, 0.1, 0.084), size_m=(0.22, 0.18, 0.006), yaw_rad=0.0)
    knob = Box3d(center_world_m=(0.95, 0.1, 0.1), size_m=(0.03, 0.03, 0.03), yaw_rad=0.0)
    reading = container(0.0, Lid(plate=plate, knob=knob))
    names = {box.name for box in obstacles_of(estimate(reading)).boxes}
    assert {"lid", "lid knob", "container floor", "container wall +x"} <= names
    taken = {box.name for box in obstacles_of(estimate(reading), lid=False).boxes}
    assert names - taken == {"lid", "lid knob"}


def test_a_box_around_a_track_is_left_out_and_its_seen_surface_counts_instead() -> None:
    hollow = Box3d(center_world_m=(0.83, 0.0, 0.05), size_m=(0.10, 0.16, 0.10), yaw_rad=0.0)
    beside = Box3d(center_world_m=(0.83, 0.3, 0.05), size_m=(0.10, 0.16, 0.10), yaw_rad=0.0)
    on_its_plate = np.array([[0.88, 0.05, 0.06]])
    seen = structs.replace(estimate(points=on_its_plate), obstacles=(hollow, beside))
    around = obstacles_of(seen)
    names = [box.name for box in around.boxes]
    assert "obstacle 0" not in names and "obstacle 1" in names
    assert np.abs(around.voxels_world_m - on_its_plate).max() <= VOXEL_M
    assert len(around.voxels_world_m) == 1
