"""The client against a tiny planner: one endpoint leads to the whole cell, events, ends."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, closing

import pytest
from tiny_process import Tiny, tiny_service

from surefetch.client import Cell
from surefetch.common import codec
from surefetch.common.bus import Call
from surefetch.common.errors import BadInput, InfrastructureError, PeerMissing, Refused
from surefetch.common.joining import find_cell
from surefetch.common.messages import Ended, Status, Stopped
from surefetch.common.settings import BusSettings, free_endpoint
from surefetch.common.topics import BELIEF, EXECUTOR, PLANNER, STATUS, STOP
from surefetch.common.zenoh_bus import ZenohBus

pytestmark = pytest.mark.system


@pytest.fixture
def tiny() -> Iterator[Tiny]:
    with tiny_service() as started:
        yield started


def joined(stack: ExitStack, tiny: Tiny, service: str) -> str:
    """A second service in the tiny one's cell; its endpoint."""
    endpoint = free_endpoint()
    bus = ZenohBus(BusSettings(tiny.cell, listen=(endpoint,), connect=(tiny.endpoint,)), service)
    stack.callback(bus.close)
    status = Status(
        service=service,
        boot=bus.boot,
        pid=1,
        host="there",
        version="0",
        backend="test",
        doing="",
        n_served=0,
        endpoints=bus.endpoints,
    )

    def say_status(call: Call) -> None:
        call.reply(codec.encode(status, max_bytes=10_000))

    def say_stopped(call: Call) -> None:
        stopped = Stopped(was_moving=True, took_s=0.25)
        call.reply(codec.encode(stopped, max_bytes=10_000))

    bus.answer(STATUS[service], say_status)
    if service == EXECUTOR:
        bus.answer(STOP, say_stopped)
    bus.announce()
    return endpoint


def test_fetching_gives_the_events_of_the_episode_until_it_has_ended(tiny: Tiny) -> None:
    with Cell(tiny.endpoint) as cell:
        events = list(cell.fetch("episode"))
        again = list(cell.fetch("episode"))
    assert [event.seq for event in events] == [0, 1, 2, 3]
    assert isinstance(events[-1].happening, Ended)
    assert {event.episode for event in events} == {"e1"}
    assert {event.episode for event in again} == {"e2"}


def test_a_refused_sentence_is_an_error_before_any_event(tiny: Tiny) -> None:
    with Cell(tiny.endpoint) as cell, pytest.raises(Refused, match="on purpose") as met:
        cell.fetch("refuse")
    assert met.value.exit_code == BadInput.exit_code


def test_a_planner_that_dies_in_an_episode_is_named(tiny: Tiny) -> None:
    with Cell(tiny.endpoint) as cell:
        start_s = time.monotonic()
        with pytest.raises(PeerMissing, match="planner died in the middle of an episode") as met:
            list(cell.fetch("die"))
        assert met.value.service == PLANNER
        assert time.monotonic() - start_s < 2.0


def test_leaving_the_loop_early_cancels_the_episode(tiny: Tiny) -> None:
    with Cell(tiny.endpoint) as cell:
        for event in cell.fetch("episode"):
            if event.seq == 1:
                break
        (status,) = cell.status()
    assert status.doing == "missed  cancelled e1"


def test_one_endpoint_leads_to_the_whole_cell(tiny: Tiny) -> None:
    with ExitStack() as stack:
        executor = joined(stack, tiny, EXECUTOR)
        found = find_cell([executor])
        assert found is not None
        assert found.name == tiny.cell
        assert {status.service for status in found.services} == {EXECUTOR, PLANNER}
        assert set(found.endpoints) == {executor, tiny.endpoint}
        with Cell(executor) as cell:
            assert cell.bus.alive() == {EXECUTOR, PLANNER}
            assert cell.stop().was_moving
            assert len(list(cell.fetch("episode"))) == 4


def test_an_endpoint_that_stands_for_all_addresses_is_not_connected_to(tiny: Tiny) -> None:
    port = free_endpoint().rsplit(":", 1)[1]
    settings = BusSettings(tiny.cell, listen=(f"tcp/0.0.0.0:{port}",), connect=(tiny.endpoint,))
    with closing(ZenohBus(settings, BELIEF)) as belief:
        belief.announce()
        found = find_cell([f"tcp/127.0.0.1:{port}"])
    assert found is not None
    assert found.endpoints == (f"tcp/127.0.0.1:{port}",)


def test_nothing_at_an_endpoint_is_told() -> None:
    endpoint = free_endpoint()
    with pytest.raises(InfrastructureError, match=f"nothing is up at {endpoint}"):
        Cell(endpoint)
    with pytest.raises(BadInput, match="cannot be used: --connect what"):
        Cell("what")


def test_endpoints_of_different_cells_are_told(tiny: Tiny) -> None:
    with tiny_service() as other, pytest.raises(InfrastructureError, match="different cells"):
        Cell(tiny.endpoint, other.endpoint)
