"""What the service keeps: frames, outcomes, the stop, and the record of a motion."""

import threading

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import structs
from tabletop import body, estimate_of, move, scene

from surefetch.common.errors import DeviceFault, Refused
from surefetch.common.messages import Command, Frame, FrameId, FrameInfo, Look, Outcome
from surefetch.executor.frames import FrameRing
from surefetch.executor.outcomes import Outcomes
from surefetch.executor.skills.execution import PICTURE_S, driven_part
from surefetch.executor.stop_latch import StopLatch

START = np.zeros(6)
END = np.array([0.5, -0.3, 0.2, 0.1, 0.0, 0.4])


def frame(counter: int, pixels: int = 100) -> Frame:
    info = FrameInfo(
        frame=FrameId(boot="here", counter=counter),
        view="center",
        width=pixels,
        height=pixels,
        K=np.eye(3),
        T_world_camera=np.eye(4),
        captured_s=1.0,
    )
    return Frame(
        info=info,
        rgb=np.zeros((pixels, pixels, 3), np.uint8),
        depth_m=np.zeros((pixels, pixels), np.float32),
        q_rad=(0.0,) * 6,
        gripper_width_m=0.0,
    )


def test_the_newest_frames_are_kept_within_their_bytes() -> None:
    ring = FrameRing("here", max_bytes=3 * 70_000)
    for counter in range(1, 6):
        ring.keep(frame(counter))
    assert ring.get(FrameId(boot="here", counter=3)).info.frame.counter == 3
    with pytest.raises(Refused, match="kept are 3 to 5") as gone:
        ring.get(FrameId(boot="here", counter=2))
    with pytest.raises(Refused, match="another executor") as other:
        ring.get(FrameId(boot="there", counter=5))
    assert (gone.value.reason, other.value.reason) == ("GONE", "WRONG_BOOT")


def test_a_frame_larger_than_the_ring_is_kept_all_the_same() -> None:
    ring = FrameRing("here", max_bytes=10)
    ring.keep(frame(1))
    assert ring.get(FrameId(boot="here", counter=1)).rgb.shape == (100, 100, 3)


def command(cmd_id: str = "a", view: str = "center") -> Command:
    estimate = estimate_of(scene(body("cube")))
    return Command(cmd_id=cmd_id, episode="e", step=0, verb=Look(view=view), estimate=estimate)


OUTCOME = Outcome(
    cmd_id="a",
    status="done",
    refusal=None,
    why="",
    checks={},
    gripper_width_m=0.0,
    holding=False,
    duration_s=1.0,
    planning_s=0.1,
    motions=(),
)


def test_a_command_is_known_by_its_id_and_told_from_another_by_its_body() -> None:
    outcomes = Outcomes()
    assert outcomes.of(command()) is None
    outcomes.keep(command(), OUTCOME)
    assert outcomes.of(command()) is OUTCOME
    assert outcomes.of(command("b")) is None
    for other in (command(view="right"), structs.replace(command(), step=1)):
        with pytest.raises(Refused, match="another one before"):
            outcomes.of(other)


def test_a_stop_that_brings_no_rest_does_not_claim_it() -> None:
    latch = StopLatch(rest_s=0.05)
    with latch.moving(), pytest.raises(DeviceFault, match="has not come to rest"):
        latch.ask_and_wait("a")
    assert latch.asked(), "and nothing more is begun"


def test_a_stop_latches_and_waits_for_rest() -> None:
    latch = StopLatch()
    assert latch.ask_and_wait("a")[0] is False
    assert latch.asked() and latch.who == "a"
    latch.ask("b")
    assert latch.who == "a", "the first one stopped it"
    latch.release()
    assert not latch.asked()
    began, end = threading.Event(), threading.Event()

    def motion() -> None:
        with latch.moving():
            began.set()
            end.wait(5.0)

    thread = threading.Thread(target=motion)
    thread.start()
    assert began.wait(5.0)
    threading.Timer(0.05, end.set).start()
    moving, took_s = latch.ask_and_wait("c")
    thread.join()
    assert moving and 0.04 < took_s < 1.0


@given(st.floats(0.02, 1.0))
def test_the_record_of_a_motion_cut_short_ends_where_the_arm_is(share: float) -> None:
    trajectory = move(START, END)
    k = max(int(share * (len(trajectory.times_s) - 1)), 1)
    driven = driven_part(trajectory, trajectory.q_rad[k] + 1e-4, arrived=False)
    assert driven.times_s[-1] == pytest.approx(trajectory.times_s[k], abs=0.04)
    assert driven.q_rad[-1] == pytest.approx(trajectory.q_rad[k] + 1e-4)
    assert (np.diff(driven.times_s) > 0.0).all() and np.diff(
        driven.times_s
    ).max() < PICTURE_S + 1e-9
    assert len(driven.times_s) == len(driven.q_rad)


def test_the_record_of_a_whole_motion_has_its_whole_time() -> None:
    driven = driven_part(move(START, END), END, arrived=True)
    assert driven.times_s[[0, -1]] == pytest.approx([0.0, 2.0])
    assert driven.q_rad[0] == pytest.approx(START)
