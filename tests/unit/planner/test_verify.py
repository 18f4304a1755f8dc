"""A look at the place from which something was taken."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from surefetch.common.geometry import intrinsics, look_at
from surefetch.common.messages import Box3d, Detection, FrameId, FrameInfo, Mask, Track, Xyz
from surefetch.planner.verify import NEAR_M, look_at_place

RED = (1.0, *([0.0] * 13))
BLUE = (*([0.0] * 13), 1.0)
HERE = (0.9, 0.0, 0.03)
FRAME = FrameInfo(
    frame=FrameId(boot="b", counter=0),
    view="center",
    width=640,
    height=480,
    K=intrinsics(640, 480, 50.0),
    T_world_camera=look_at(np.array([0.4, 0.0, 0.5]), np.array(HERE), np.array([0.0, 0.0, 1.0])),
    captured_s=0.0,
)


def solid(at_m: Xyz, size_m: Xyz = (0.05, 0.05, 0.06)) -> Box3d:
    return Box3d(center_world_m=at_m, size_m=size_m, yaw_rad=0.0)


def track(number: int, at_m: Xyz, hist: tuple[float, ...] | None = RED) -> Track:
    return Track(
        id=number,
        center_world_m=at_m,
        solid=solid(at_m),
        points_world_m=np.zeros((0, 3), np.float32),
        hist=hist,
        n_observations=1,
        y0="MO",
        last_detection="d",
        last_step=0,
    )


def detection(at_m: Xyz | None, hist: tuple[float, ...] | None = RED) -> Detection:
    return Detection(
        id="d",
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        phrase="thing",
        mask=Mask(height=1, width=1, counts=(1,)),
        group=0,
        representative=True,
        center_world_m=at_m,
        solid=at_m and solid(at_m),
        points_world_m=np.zeros((0, 3), np.float32),
        hist=hist,
        answers=None,
    )


def gone(*seen: Detection, others: tuple[Track, ...] = (), taken: Track | None = None) -> object:
    return look_at_place(taken or track(1, HERE), others, FRAME, seen, "center").gone


def test_nothing_there_is_gone() -> None:
    assert gone() is True


@settings(deadline=None)
@given(st.floats(-0.9, 0.9), st.floats(-0.4, 0.4))
def test_the_same_body_near_its_place_is_still_there(share: float, up: float) -> None:
    near = (HERE[0] + share * NEAR_M, HERE[1], HERE[2] + up * NEAR_M)
    assert gone(detection(near)) is False


@settings(deadline=None)
@given(st.floats(1.01, 5.0), st.floats(0.0, 2 * np.pi))
def test_a_body_farther_away_is_another(share: float, angle: float) -> None:
    x, y = share * NEAR_M * np.cos(angle), share * NEAR_M * np.sin(angle)
    assert gone(detection((HERE[0] + x, HERE[1] + y, HERE[2]))) is True


def test_what_was_hidden_behind_it_is_told_by_its_colour() -> None:
    behind = (HERE[0] + 0.03, HERE[1], HERE[2])
    assert gone(detection(behind, BLUE)) is True


def test_a_neighbour_in_its_own_place_is_the_neighbour() -> None:
    beside = (HERE[0], HERE[1] + 0.035, HERE[2])
    assert gone(detection(beside), others=(track(2, beside),)) is True
    assert gone(detection(HERE), others=(track(2, beside),)) is False


def test_without_colours_the_size_tells() -> None:
    colorless = track(1, HERE, None)
    flat = replace(detection(HERE), solid=solid(HERE, (0.05, 0.05, 0.02)))
    assert gone(detection(HERE), taken=colorless) is False
    assert gone(flat, taken=colorless) is True
    assert gone(replace(detection(HERE), solid=None), taken=colorless) is False


def test_a_detection_without_a_centre_says_nothing() -> None:
    assert gone(detection(None)) is True


@pytest.mark.parametrize("view", ["right", None])
def test_only_the_view_from_which_it_was_seen_shows_that_nothing_hides_its_place(
    view: str | None,
) -> None:
    check = look_at_place(track(1, HERE), (), FRAME, (), view)
    assert check.gone is None
    assert "could not be seen again" in check.why


@pytest.mark.parametrize("at_m", [(0.9, 2.0, 0.03), (-1.0, 0.0, 0.03)])
def test_a_place_outside_the_image_is_not_seen(at_m: Xyz) -> None:
    assert gone(taken=track(1, at_m)) is None
