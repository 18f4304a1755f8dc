import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from surefetch.common.cell import simulated_cell
from surefetch.common.geometry import Array, rigid
from surefetch.executor.motion.collision import FINGERS, CollisionScene, Held
from surefetch.executor.motion.obstacles import NamedBox, Obstacles
from surefetch.executor.robot import ur10e

CELL = simulated_cell()
HOME = np.radians(CELL.home.q_deg)
NOTHING = Obstacles((), np.zeros((0, 3)))
BARE = CollisionScene(ur10e.camera_mount(CELL.camera), NOTHING)
NEAR_HOME = arrays(np.float64, 6, elements=st.floats(-1.2, 1.2)).map(lambda d: HOME + d)


def cube(name: str, center_m: Array, edge_m: float = 0.05) -> NamedBox:
    return NamedBox(name, rigid(np.eye(3), np.asarray(center_m)), np.full(3, edge_m))


def among(*boxes: NamedBox) -> CollisionScene:
    return CollisionScene(BARE.T_flange_camera, Obstacles(boxes, np.zeros((0, 3))))


def between_the_fingers(q: Array) -> Array:
    """Where the fingertips' ends are, (3,)."""
    tip: Array = (ur10e.flange(q) @ ur10e.tcp(0.08))[:3, 3]
    return tip


def test_the_arm_is_free_at_home() -> None:
    assert BARE.in_collision(HOME, 0.08) is None


@pytest.mark.parametrize(
    ("q_deg", "parts"),
    [
        ([0.0, 20.0, 0.0, 0.0, 0.0, 0.0], {"table"}),
        ([0.0, -90.0, 150.0, -90.0, -90.0, 0.0], {"gripper body", "table"}),
        ([0.0, -90.0, 90.0, 0.0, -90.0, 90.0], {"forearm", "camera body"}),
    ],
)
def test_known_collisions_are_found(q_deg: list[float], parts: set[str]) -> None:
    hit = BARE.in_collision(np.radians(q_deg), 0.0)
    assert hit is not None
    assert parts <= set(hit)


def test_a_box_between_the_fingers_is_named_with_the_part_that_touches_it() -> None:
    hit = among(cube("track 3", between_the_fingers(HOME), 0.12)).in_collision(HOME, 0.08)
    assert hit is not None
    assert hit[0] in FINGERS and hit[1] == "track 3"


def test_a_surface_point_in_the_way_is_an_obstacle() -> None:
    finger = ur10e.flange(HOME)[:3, :3] @ ur10e.finger_centers(0.08)[0] + ur10e.flange(HOME)[:3, 3]
    scene = CollisionScene(BARE.T_flange_camera, Obstacles((), finger[None]))
    assert scene.in_collision(HOME, 0.08) == ("left finger", "seen surface")


def test_an_allowed_pair_may_touch_and_nothing_else() -> None:
    pairs = [(finger, "track 3") for finger in FINGERS]
    inside = cube("track 3", between_the_fingers(HOME), 0.12)
    assert among(inside).allowing(pairs).in_collision(HOME, 0.08) is None
    second = cube("track 4", between_the_fingers(HOME), 0.12)
    hit = among(inside, second).allowing(pairs).in_collision(HOME, 0.08)
    assert hit is not None and hit[1] == "track 4"


def test_a_held_object_counts_until_it_is_let_go() -> None:
    below = rigid(np.eye(3), np.array([0.0, 0.0, 0.30]))
    box = cube("track 1", (ur10e.flange(HOME) @ below)[:3, 3], 0.02)
    scene = among(box)
    assert scene.in_collision(HOME, 0.08) is None
    held = scene.holding(Held(below, np.full(3, 0.04)))
    assert held.in_collision(HOME, 0.08) == ("held", "track 1")
    assert held.holding(None).in_collision(HOME, 0.08) is None


@given(NEAR_HOME)
def test_what_touches_with_less_padding_touches_with_more(q: Array) -> None:
    thin = CollisionScene(BARE.T_flange_camera, NOTHING, padding_m=0.0)
    if thin.in_collision(q, 0.05) is not None:
        assert BARE.in_collision(q, 0.05) is not None


@given(NEAR_HOME, st.floats(0.0, 0.16))
def test_more_obstacles_never_free_the_arm(q: Array, width_m: float) -> None:
    assume(BARE.in_collision(q, width_m) is not None)
    more = among(cube("track 1", np.array([0.9, 0.0, 0.03])))
    assert more.in_collision(q, width_m) is not None


@given(st.lists(NEAR_HOME, min_size=1, max_size=6))
def test_many_states_at_once_are_judged_as_one_by_one(q: list[Array]) -> None:
    scene = among(cube("track 1", np.array([0.55, 0.0, 0.2]), 0.2))
    alone = [scene.in_collision(row, 0.08) for row in q]
    first = next((i for i, hit in enumerate(alone) if hit is not None), None)
    hit = scene.first_collision(np.array(q), 0.08)
    assert (None if hit is None else hit[0]) == first
