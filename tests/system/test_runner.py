"""What the runner promises, seen from outside: a service in a process of its own, over Zenoh."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from queue import Queue

import pytest
import zenoh
from tiny_process import PROGRAM, Tiny, tiny_service

from surefetch.client import Cell
from surefetch.common import codec, refusals
from surefetch.common.errors import PeerMissing, Refused, SurefetchError
from surefetch.common.host import MAX_WAITING
from surefetch.common.journal import parse_journal
from surefetch.common.launch import own_cell_name
from surefetch.common.messages import Accepted, Cancel, Empty, Instruct, RefusedReply
from surefetch.common.settings import BusSettings, free_endpoint
from surefetch.common.topics import BELIEF, CANCEL, PLANNER, STATUS
from surefetch.common.zenoh_bus import ZenohBus

pytestmark = pytest.mark.system


@pytest.fixture
def tiny() -> Iterator[Tiny]:
    with tiny_service() as started:
        yield started


def ask_meanwhile(tiny: Tiny, sentence: str) -> "Queue[Accepted | SurefetchError]":
    """Ask from another thread, and give the question time to arrive."""
    results: Queue[Accepted | SurefetchError] = Queue()

    def ask() -> None:
        try:
            results.put(tiny.instruct(sentence))
        except SurefetchError as error:
            results.put(error)

    threading.Thread(target=ask, daemon=True).start()
    time.sleep(0.1)
    return results


def test_questions_are_answered_by_the_work_loop_in_the_main_thread(tiny: Tiny) -> None:
    assert tiny.instruct("answer").understood == "MainThread"


def test_a_concurrent_question_is_answered_while_the_work_loop_is_busy(tiny: Tiny) -> None:
    first = ask_meanwhile(tiny, "sleep 4")
    tiny.bus.ask(CANCEL, Cancel(episode="e7"), timeout_s=2.0)
    status = tiny.bus.ask(STATUS[PLANNER], Empty(), timeout_s=2.0)
    assert first.empty()
    assert status.doing == "missed  cancelled e7"
    assert status.pid == tiny.process.pid
    assert status.endpoints == (tiny.endpoint,)
    assert isinstance(first.get(timeout=5.0), Accepted)


def test_a_reply_leaves_before_the_work_that_it_announces(tiny: Tiny) -> None:
    start_s = time.monotonic()
    tiny.instruct("later 3")
    assert time.monotonic() - start_s < 2.0
    tiny.instruct("answer")
    assert time.monotonic() - start_s > 2.9


def test_a_refusal_reaches_the_asker_and_the_service_serves_on(tiny: Tiny) -> None:
    with pytest.raises(Refused, match="refused on purpose") as met:
        tiny.instruct("refuse")
    assert (met.value.reason, met.value.exit_code) == (refusals.BAD_INPUT, 2)
    assert tiny.instruct("answer").episode == "e0"


@pytest.mark.parametrize("where", ["work loop", "job", "concurrent"])
def test_an_unexpected_error_ends_the_process(tiny: Tiny, where: str) -> None:
    start_s = time.monotonic()
    if where == "job":
        tiny.instruct("later crash")
    else:
        with pytest.raises(PeerMissing, match="planner died while it was asked"):
            if where == "concurrent":
                tiny.bus.ask(CANCEL, Cancel(episode="crash"), timeout_s=10.0)
            else:
                tiny.instruct("crash")
    assert tiny.exit_status() == 70
    assert time.monotonic() - start_s < 2.0
    assert tiny.process.stderr is not None
    assert "ValueError: crashed on purpose" in tiny.process.stderr.read()


def test_a_killed_service_is_missed_long_before_its_answer_was_due(tiny: Tiny) -> None:
    asked = ask_meanwhile(tiny, "sleep 20")
    start_s = time.monotonic()
    tiny.process.kill()
    error = asked.get(timeout=5.0)
    assert time.monotonic() - start_s < 2.0
    assert isinstance(error, PeerMissing)
    assert error.service == PLANNER


def test_a_service_is_told_when_another_one_is_gone(tiny: Tiny) -> None:
    settings = BusSettings(tiny.cell, listen=(free_endpoint(),), connect=(tiny.endpoint,))
    with closing(ZenohBus(settings, BELIEF)) as belief:
        belief.announce()
        tiny.instruct("answer")
    deadline_s = time.monotonic() + 2.0
    while time.monotonic() < deadline_s:
        status = tiny.bus.ask(STATUS[PLANNER], Empty(), timeout_s=1.0)
        if "missed belief" in status.doing:
            return
    pytest.fail(f"the service was not told: {status.doing}")


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_an_idle_service_at_once(number: signal.Signals) -> None:
    with tiny_service("--ends-gently") as tiny:  # given up after 3 s
        start_s = time.monotonic()
        tiny.process.send_signal(number)
        assert tiny.exit_status() == 0
        assert time.monotonic() - start_s < 2.0


def test_a_signal_that_another_thread_gets_ends_the_service_all_the_same() -> None:
    """The kernel may give it to any thread; Python runs the handler in the main one alone."""
    with tiny_service("--ends-gently") as tiny:  # given up after 3 s
        start_s = time.monotonic()
        tiny.bus.ask(CANCEL, Cancel(episode="signal"), timeout_s=2.0)
        assert tiny.exit_status() == 0
        assert time.monotonic() - start_s < 2.0


def test_a_signal_ends_a_busy_service_long_before_its_work_is_done(tiny: Tiny) -> None:
    ask_meanwhile(tiny, "sleep 20")
    start_s = time.monotonic()
    tiny.process.terminate()
    assert tiny.exit_status() == 0
    assert time.monotonic() - start_s < 3.0


def test_a_service_that_ends_gently_is_given_the_time() -> None:
    with tiny_service("--ends-gently") as tiny:
        ask_meanwhile(tiny, "until the end")
        tiny.process.terminate()
        assert tiny.exit_status() == 0
        assert tiny.process.stdout is not None
        assert tiny.process.stdout.read() == "brought to rest\n"


def test_a_service_ends_when_its_parent_is_killed() -> None:
    endpoint, cell = free_endpoint(), own_cell_name()
    program = (
        "import os, subprocess, sys, time\n"
        f"words = [sys.executable, {str(PROGRAM)!r}, '--listen', {endpoint!r}]\n"
        f"words += ['--name', {cell!r}, '--parent-pid', str(os.getpid())]\n"
        "child = subprocess.Popen(words)\n"
        "print(child.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    child = int(parent.stdout.readline())
    assert "ready" in parent.stdout.readline()
    parent.kill()
    parent.communicate()
    deadline_s = time.monotonic() + 3.0
    while is_there(child) and time.monotonic() < deadline_s:
        time.sleep(0.02)
    assert not is_there(child)


def is_there(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_the_journal_holds_every_question_and_what_came_of_it(tiny: Tiny) -> None:
    tiny.instruct("answer")
    with pytest.raises(Refused):
        tiny.instruct("refuse")
    tiny.bus.ask(CANCEL, Cancel(episode="e7"), timeout_s=1.0)
    tiny.instruct("episode")
    tiny.instruct("answer")  # after the episode, which is done by the work loop
    journal = parse_journal(Cell.on(tiny.bus).journal(PLANNER), "planner")
    assert (journal.header.service, journal.torn_bytes) == (PLANNER, 0)
    assert [record.seq for record in journal.records] == list(range(len(journal.records)))
    said = [(record.kind, record.topic) for record in journal.records]
    question, reply = ("request", "planner/instruct"), ("reply", "planner/instruct")
    assert said == [
        question,
        reply,
        question,
        ("refusal", "planner/instruct"),
        ("request", "planner/cancel"),
        ("reply", "planner/cancel"),
        question,
        reply,
        *[("event", "planner/event")] * 4,
        question,
        reply,
    ]
    first, answer, refused, no = journal.records[:4]
    assert first.message(Instruct).sentence == "answer"
    assert answer.message(Accepted).understood == "MainThread"
    assert no.message(RefusedReply).text == "refused on purpose"
    assert (first.call, refused.call) == (answer.call, no.call)


def test_bytes_that_are_no_message_are_refused_and_the_service_serves_on(tiny: Tiny) -> None:
    boot = tiny.bus.ask(STATUS[PLANNER], Empty(), timeout_s=1.0).boot
    config = zenoh.Config()
    config.insert_json5("connect/endpoints", f'["{tiny.endpoint}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        key = f"cell/{tiny.cell}/planner/{boot}/instruct"
        for payload in (None, b"", b"\xc1", b"\x00" * 70_000):
            (reply,) = list(session.get(key, payload=payload, timeout=2.0))
            assert reply.err is not None
            content = reply.err.payload.to_bytes()
            refusal = codec.decode(content, RefusedReply, max_bytes=10_000)
            assert refusal.reason == refusals.BAD_SCHEMA
    assert tiny.instruct("answer").episode == "e0"


def test_more_questions_than_can_wait_are_refused_as_busy(tiny: Tiny) -> None:
    first = ask_meanwhile(tiny, "sleep 1.0")
    results: Queue[str] = Queue()

    def ask() -> None:
        try:
            results.put(tiny.instruct("answer").episode)
        except Refused as error:
            results.put(error.reason)

    n_asked = MAX_WAITING + 6
    threads = [threading.Thread(target=ask, daemon=True) for _ in range(n_asked)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(10.0)
    answers = [results.get() for _ in range(n_asked)]
    assert answers.count(refusals.BUSY) == 6
    assert answers.count("e0") == MAX_WAITING
    assert isinstance(first.get(timeout=5.0), Accepted)
