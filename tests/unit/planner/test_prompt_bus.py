"""A question ends when any needed service dies, and none is sent afterwards."""

import threading

import pytest

from surefetch.common.bus import Call
from surefetch.common.errors import CodecError, PeerMissing
from surefetch.common.local_bus import LocalBus, LocalCell
from surefetch.common.messages import Capture, FrameInfo
from surefetch.common.topics import BELIEF, CAPTURE, EXECUTOR, PERCEPTION
from surefetch.planner.prompt_bus import PromptBus


class Slow:
    """An executor that answers when it is told to."""

    def __init__(self) -> None:
        self.asked = 0
        self.heard, self.go_on = threading.Event(), threading.Event()

    def on_call(self, call: Call) -> None:
        self.asked += 1
        self.heard.set()
        threading.Thread(target=self._answer, args=(call,), daemon=True).start()

    def _answer(self, call: Call) -> None:
        self.go_on.wait(10.0)
        call.reply(b"no message")


@pytest.fixture
def slow() -> Slow:
    return Slow()


@pytest.fixture
def bus(slow: Slow) -> PromptBus:
    cell = LocalCell()
    executor = LocalBus(cell, EXECUTOR)
    executor.answer(CAPTURE, slow.on_call)
    executor.announce()
    return PromptBus(LocalBus(cell), frozenset({EXECUTOR, PERCEPTION}))


def capture(bus: PromptBus) -> FrameInfo:
    return bus.ask(CAPTURE, Capture(episode="e", step=0), timeout_s=10.0)


def test_a_death_elsewhere_ends_the_question_under_way(bus: PromptBus, slow: Slow) -> None:
    def kill() -> None:
        slow.heard.wait(5.0)
        bus.peer_gone(PERCEPTION)

    killer = threading.Thread(target=kill)
    killer.start()
    with pytest.raises(PeerMissing) as missing:
        capture(bus)
    killer.join()
    assert missing.value.service == PERCEPTION


def test_nothing_is_asked_after_a_death(bus: PromptBus, slow: Slow) -> None:
    bus.peer_gone(PERCEPTION)
    with pytest.raises(PeerMissing, match=PERCEPTION):
        capture(bus)
    assert slow.asked == 0


def test_a_service_that_is_not_needed_may_die(bus: PromptBus, slow: Slow) -> None:
    bus.peer_gone(BELIEF)
    slow.go_on.set()
    with pytest.raises(CodecError, match="FrameInfo"):
        capture(bus)
    assert slow.asked == 1


def test_a_new_episode_does_not_inherit_the_dead(bus: PromptBus, slow: Slow) -> None:
    bus.peer_gone(PERCEPTION)
    bus.begin()
    slow.go_on.set()
    with pytest.raises(CodecError, match="FrameInfo"):
        capture(bus)
