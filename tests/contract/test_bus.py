"""What every bus promises, asked of the local one and of real Zenoh over loopback."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from queue import Queue
from typing import Protocol

import numpy as np
import pytest
import zenoh

from surefetch.common import codec, refusals
from surefetch.common import messages as m
from surefetch.common.bus import Call, ServingBus
from surefetch.common.errors import (
    BadInput,
    CodecError,
    DeviceFault,
    InfrastructureError,
    NoAnswer,
    PeerMissing,
    Refused,
    SurefetchError,
)
from surefetch.common.launch import own_cell_name
from surefetch.common.local_bus import LocalBus, LocalCell
from surefetch.common.settings import BusSettings, free_endpoint
from surefetch.common.topics import (
    BELIEF,
    CANCEL,
    CAPTURE,
    EVENTS,
    EXECUTOR,
    FRAME,
    INSTRUCT,
    MOVED,
    PLANNER,
    STATUS,
    STOP,
    TRUTH,
)
from surefetch.common.zenoh_bus import ZenohBus


class Cell(Protocol):
    """Makes buses of one cell; all are closed at the end of a test."""

    def __call__(self, service: str | None = None) -> ServingBus: ...


def local_cell(stack: ExitStack) -> Cell:
    shared = LocalCell()

    def bus(service: str | None = None) -> ServingBus:
        made = LocalBus(shared, service)
        stack.callback(made.close)
        return made

    return bus


def zenoh_cell(stack: ExitStack) -> Cell:
    name = own_cell_name()
    endpoints: list[str] = []

    def bus(service: str | None = None) -> ServingBus:
        own = free_endpoint()
        made = ZenohBus(BusSettings(name, listen=(own,), connect=tuple(endpoints)), service)
        endpoints.append(own)
        stack.callback(made.close)
        return made

    return bus


@pytest.fixture(params=[local_cell, zenoh_cell], ids=["local", "zenoh"])
def cell(request: pytest.FixtureRequest) -> Iterator[Cell]:
    with ExitStack() as stack:
        yield request.param(stack)


def reply_with(message: m.Message) -> Callable[[Call], None]:
    return lambda call: call.reply(codec.encode(message, max_bytes=call.topic.max_reply_bytes))


def refuse_with(error: SurefetchError) -> Callable[[Call], None]:
    return lambda call: call.refuse(refusals.refusal_of(error))


def stay_silent(into: list[Call]) -> Callable[[Call], None]:
    return into.append


def planner_that(cell: Cell, on_cancel: Callable[[Call], None]) -> ServingBus:
    planner = cell(PLANNER)
    planner.answer(CANCEL, on_cancel)
    planner.announce()
    return planner


def cancel(bus: ServingBus, timeout_s: float = 5.0) -> m.Empty:
    return bus.ask(CANCEL, m.Cancel(episode="7"), timeout_s=timeout_s)


def until(condition: Callable[[], bool], timeout_s: float = 3.0) -> bool:
    deadline_s = time.monotonic() + timeout_s
    while not condition() and time.monotonic() < deadline_s:
        time.sleep(0.002)
    return condition()


def test_an_answer_is_what_was_replied_and_the_question_what_was_asked(cell: Cell) -> None:
    asked: list[m.Cancel] = []

    def on_cancel(call: Call) -> None:
        limit = CANCEL.max_request_bytes
        asked.append(codec.decode(call.encoded, m.Cancel, max_bytes=limit))
        reply_with(m.Empty())(call)

    planner_that(cell, on_cancel)
    assert cancel(cell()) == m.Empty()
    assert asked == [m.Cancel(episode="7")]


def test_a_large_frame_arrives_bit_by_bit(cell: Cell) -> None:
    rng = np.random.default_rng(1)
    info = m.FrameInfo(
        frame=m.FrameId(boot="b", counter=1),
        view="center",
        width=640,
        height=480,
        K=np.eye(3),
        T_world_camera=np.eye(4),
        captured_s=0.0,
    )
    frame = m.Frame(
        info=info,
        rgb=rng.integers(0, 256, (480, 640, 3), dtype=np.uint8),
        depth_m=rng.random((480, 640), dtype=np.float32),
        q_rad=(0.0,) * 6,
        gripper_width_m=0.1,
    )
    executor = cell(EXECUTOR)
    executor.answer(FRAME, reply_with(frame))
    executor.announce()
    back = cell().ask(FRAME, frame.info.frame, timeout_s=5.0)
    assert np.array_equal(back.rgb, frame.rgb)
    assert np.array_equal(back.depth_m, frame.depth_m)


@pytest.mark.parametrize(
    "error",
    [
        BadInput("the word blorp is not understood"),
        Refused("BUSY", "an episode is running", 1),
        DeviceFault("the gripper did not close"),
        PeerMissing("belief", "belief is not there"),
        NoAnswer("executor", "executor did not answer"),
        CodecError("Cancel: field missing"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_a_refusal_keeps_its_words_exit_code_and_the_service_that_is_missing(
    cell: Cell, error: SurefetchError
) -> None:
    planner_that(cell, refuse_with(error))
    with pytest.raises(SurefetchError) as met:
        cancel(cell())
    assert str(met.value) == str(error)
    assert met.value.exit_code == error.exit_code
    if isinstance(error, PeerMissing | NoAnswer | Refused):
        assert type(met.value) is type(error)
    for name in ("service", "reason"):
        assert getattr(met.value, name, None) == getattr(
            error, name, getattr(met.value, name, None)
        )


def test_a_refusal_that_is_passed_on_stays_what_it_was(cell: Cell) -> None:
    """An operator asks the planner, which asks an executor that is not there."""
    planner = cell(PLANNER)

    def on_cancel(call: Call) -> None:
        def ask_executor() -> None:
            try:
                planner.ask(CAPTURE, m.Capture(episode="7", step=0), timeout_s=0.2)
            except SurefetchError as error:
                call.refuse(refusals.refusal_of(error))

        threading.Thread(target=ask_executor).start()

    planner.answer(CANCEL, on_cancel)
    planner.announce()
    with pytest.raises(PeerMissing, match="executor is not there") as met:
        cancel(cell())
    assert met.value.service == EXECUTOR


def test_a_service_that_is_not_there_is_named_with_those_that_are(cell: Cell) -> None:
    planner_that(cell, reply_with(m.Empty()))
    bus = cell()
    assert until(lambda: bus.alive() == {PLANNER})
    with pytest.raises(PeerMissing, match="belief is not there") as met:
        bus.ask(STATUS[BELIEF], m.Empty(), timeout_s=0.3)
    assert met.value.service == BELIEF
    assert "Up: planner" in str(met.value)


def test_a_service_that_comes_while_it_is_waited_for_is_asked(cell: Cell) -> None:
    asker, answers = cell(), Queue[m.Empty]()
    threading.Thread(target=lambda: answers.put(cancel(asker)), daemon=True).start()
    time.sleep(0.2)
    planner_that(cell, reply_with(m.Empty()))
    assert answers.get(timeout=5.0) == m.Empty()


def test_a_service_that_dies_while_it_is_asked_is_missed_at_once(cell: Cell) -> None:
    calls: list[Call] = []
    planner, bus = planner_that(cell, stay_silent(calls)), cell()

    def die_when_asked() -> None:
        until(lambda: bool(calls))
        planner.close()

    threading.Thread(target=die_when_asked).start()
    start_s = time.monotonic()
    with pytest.raises(PeerMissing, match="planner died while it was asked for planner/cancel"):
        cancel(bus, timeout_s=20.0)
    assert time.monotonic() - start_s < 2.0


def test_silence_ends_at_the_time_that_the_asker_gave(cell: Cell) -> None:
    calls: list[Call] = []
    planner_that(cell, stay_silent(calls))
    bus = cell()
    start_s = time.monotonic()
    with pytest.raises(NoAnswer, match="planner did not answer planner/cancel within 0.3 s") as met:
        cancel(bus, timeout_s=0.3)
    assert met.value.service == PLANNER
    assert time.monotonic() - start_s < 2.0


def test_a_late_answer_is_nobodys_answer(cell: Cell) -> None:
    calls: list[Call] = []
    planner_that(cell, stay_silent(calls))
    bus = cell()
    with pytest.raises(NoAnswer):
        cancel(bus, timeout_s=0.2)
    refuse_with(Refused("LATE", "the answer to the first question"))(calls[0])
    answering = threading.Thread(
        target=lambda: until(lambda: len(calls) == 2) and reply_with(m.Empty())(calls[1])
    )
    answering.start()
    assert cancel(bus) == m.Empty()
    answering.join()


def test_an_asker_that_leaves_hears_so(cell: Cell) -> None:
    calls: list[Call] = []
    planner_that(cell, stay_silent(calls))
    bus, errors = cell(), Queue[SurefetchError]()

    def ask() -> None:
        try:
            cancel(bus, timeout_s=20.0)
        except SurefetchError as error:
            errors.put(error)

    threading.Thread(target=ask, daemon=True).start()
    assert until(lambda: bool(calls))
    bus.close()
    assert "leaving the bus" in str(errors.get(timeout=2.0))


def test_a_question_that_is_too_large_is_not_sent(cell: Cell) -> None:
    calls: list[Call] = []
    planner = cell(PLANNER)
    planner.answer(INSTRUCT, stay_silent(calls))
    planner.announce()
    request = m.Instruct(sentence="€" * 20_000, profile="p" * 100, policy="ours")
    assert len(request.sentence.encode()) < INSTRUCT.max_request_bytes
    fits = codec.encode(request, max_bytes=INSTRUCT.max_request_bytes)
    assert len(fits) > 60_000
    wide = m.Instruct(sentence="𝄞" * 20_000, profile="p", policy="ours")
    with pytest.raises(CodecError, match="Instruct: .* at most 65536 are allowed"):
        cell().ask(INSTRUCT, wide, timeout_s=1.0)
    assert calls == []


def test_an_answer_that_is_too_large_is_refused_by_the_asker_or_before(cell: Cell) -> None:
    def on_cancel(call: Call) -> None:
        too_large = codec.encode(m.RefusedReply(reason="r", text="x" * 20_000), max_bytes=10**6)
        try:
            call.reply(too_large * 4)
        except CodecError as error:
            call.refuse(refusals.refusal_of(error))

    planner_that(cell, on_cancel)
    with pytest.raises(SurefetchError, match="80[0-9]{3} bytes"):
        cancel(cell())


def test_an_answer_that_is_another_message_is_an_error_that_says_so(cell: Cell) -> None:
    planner_that(cell, reply_with(m.Stopped(was_moving=False, took_s=0.0)))
    with pytest.raises(CodecError, match="expected a message Empty, found 'Stopped'"):
        cancel(cell())


def test_two_processes_of_one_name_are_refused_and_one_of_them_is_enough_again(
    cell: Cell,
) -> None:
    planner_that(cell, reply_with(m.Empty()))
    second = planner_that(cell, reply_with(m.Empty()))
    bus = cell()
    assert cancel_is_refused_for_two(bus)
    second.close()
    assert cancel(bus) == m.Empty()


def cancel_is_refused_for_two(bus: ServingBus) -> bool:
    """A bus that joins hears of one before the other; soon it knows both."""

    def refused() -> bool:
        try:
            cancel(bus)
        except InfrastructureError as error:
            return "2 processes called planner are up in cell" in str(error)
        return False

    return until(refused)


def test_every_executor_hears_a_stop(cell: Cell) -> None:
    heard: list[str] = []

    def executor(name: str) -> None:
        bus = cell(EXECUTOR)

        def on_stop(call: Call) -> None:
            heard.append(name)
            reply_with(m.Stopped(was_moving=False, took_s=0.0))(call)

        bus.answer(STOP, on_stop)
        bus.announce()

    executor("first")
    executor("second")
    bus = cell()
    assert until(lambda: EXECUTOR in bus.alive())
    time.sleep(0.1)
    assert bus.ask(STOP, m.Stop(who="test"), timeout_s=2.0).took_s == 0.0
    assert until(lambda: sorted(heard) == ["first", "second"])


def test_whoever_listens_hears_every_message_in_order(cell: Cell) -> None:
    planner, heard, second = planner_that(cell, reply_with(m.Empty())), list[int](), list[int]()
    bus = cell()
    bus.listen(EVENTS, lambda event: heard.append(event.seq))
    bus.listen(EVENTS, lambda event: second.append(event.seq))
    cancel(bus)  # the planner knows of the listeners by now
    for seq in range(50):
        planner.publish(EVENTS, event(seq))
    assert until(lambda: heard == second == list(range(50)))


def event(seq: int) -> m.Event:
    acting = m.Acting(cmd_id=f"c{seq}", verb=m.Look(view="center"))
    return m.Event(episode="7", seq=seq, step=0, happening=acting)


def test_publishing_needs_no_listener(cell: Cell) -> None:
    cell(PLANNER).publish(EVENTS, event(0))


def test_a_message_that_is_too_large_is_not_published(cell: Cell) -> None:
    n = MOVED.max_bytes // 8
    motion = m.Motion(
        label="x", times_s=np.zeros(n), q_rad=np.zeros((n, 6)), gripper_width_m=np.zeros(n)
    )
    with pytest.raises(CodecError, match="Motion"):
        cell(EXECUTOR).publish(MOVED, motion)


def test_the_living_are_known_and_who_goes_is_told(cell: Cell) -> None:
    gone: list[str] = []
    bus = cell()
    bus.on_gone(gone.append)
    assert bus.alive() == frozenset()
    planner = planner_that(cell, reply_with(m.Empty()))
    assert until(lambda: bus.alive() == {PLANNER})
    planner.close()
    assert until(lambda: gone == [PLANNER])
    assert bus.alive() == frozenset()


def test_a_service_may_ask_only_what_the_table_lets_it_ask(cell: Cell) -> None:
    executor = cell(EXECUTOR)
    executor.answer(TRUTH, stay_silent([]))
    executor.announce()
    with pytest.raises(RuntimeError, match="planner may not ask executor/truth"):
        cell(PLANNER).ask(TRUTH, m.AskTruth(), timeout_s=0.5)


def test_a_question_to_a_key_that_is_not_literally_ours_is_refused() -> None:
    """A wildcard would reach every process that answers the topic; an access rule may let it by."""
    name, endpoint = own_cell_name(), free_endpoint()
    calls: list[Call] = []
    config = zenoh.Config()
    config.insert_json5("connect/endpoints", f'["{endpoint}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    with closing(ZenohBus(BusSettings(name, listen=(endpoint,)), PLANNER)) as planner:
        planner.answer(CANCEL, stay_silent(calls))
        planner.announce()
        with zenoh.open(config) as session:
            key = f"cell/{name}/planner/*/cancel"
            content = codec.encode(m.Cancel(episode="7"), max_bytes=1000)
            (reply,) = list(session.get(key, payload=content, timeout=2.0))
    assert reply.err is not None
    refusal = codec.decode(reply.err.payload.to_bytes(), m.RefusedReply, max_bytes=10_000)
    assert refusal.reason == refusals.BAD_KEY
    assert calls == []


def test_many_askers_at_once_each_get_their_own_answer(cell: Cell) -> None:
    def on_instruct(call: Call) -> None:
        asked = codec.decode(call.encoded, m.Instruct, max_bytes=INSTRUCT.max_request_bytes)
        target = m.Target(noun="object")
        reply_with(m.Accepted(episode="e", target=target, understood=asked.sentence))(call)

    planner = cell(PLANNER)
    planner.answer(INSTRUCT, on_instruct)
    planner.announce()
    bus, answers = cell(), dict[int, str]()

    def ask(n: int) -> None:
        request = m.Instruct(sentence=str(n), profile="p", policy="q")
        answers[n] = bus.ask(INSTRUCT, request, timeout_s=5.0).understood

    threads = [threading.Thread(target=ask, args=(n,)) for n in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == {n: str(n) for n in range(16)}
