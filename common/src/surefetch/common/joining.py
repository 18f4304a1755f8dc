"""From one endpoint of a running cell to all of it.

Peers do not forward, so whoever joins needs a link to every service. One service is asked where it
listens and whom it connects to, then those are asked, until nothing new is named.
"""

import time
from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Final

from surefetch.common.errors import InfrastructureError, SurefetchError
from surefetch.common.messages import Empty, Status
from surefetch.common.settings import BusSettings
from surefetch.common.topics import SERVICES, STATUS
from surefetch.common.zenoh_bus import ZenohBus, live_cells

FIND_S: Final = 3.0
"""How long to wait for the first sign of a service."""
LINK_S: Final = 0.3
"""How long to wait for links to open after the first one did."""
STATUS_S: Final = 2.0
_ANY_ADDRESS: Final = ("/0.0.0.0:", "/[::]:", "/*:")


@dataclass(frozen=True)
class FoundCell:
    """A cell that is up, or a part of one."""

    name: str
    endpoints: tuple[str, ...]
    """Where its services are reached."""
    services: tuple[Status, ...]
    """What those services say that answered."""


def find_cell(connect: Sequence[str], *, find_s: float = FIND_S) -> FoundCell | None:
    """The cell behind these endpoints, or None if nothing is up there.

    Raises:
        BadInput: an endpoint cannot be used.
        InfrastructureError: the endpoints belong to different cells.
    """
    names = live_cells(tuple(connect), find_s)
    if not names:
        return None
    if len(names) > 1:
        raise InfrastructureError(
            f"{_words(connect)} lead to different cells: {', '.join(sorted(names))}.\n"
            f"  Name the endpoints of one cell only."
        )
    (name,) = names
    endpoints, services = set(connect), tuple[Status, ...]()
    for _ in SERVICES:
        with ExitStack() as stack:
            bus = ZenohBus(BusSettings(name, connect=tuple(sorted(endpoints))))
            stack.callback(bus.close)
            services = _statuses(bus)
        named = {e for status in services for e in status.endpoints if _reachable(e)}
        if named <= endpoints:
            break
        endpoints |= named
    return FoundCell(name, tuple(sorted(endpoints)), services)


def join(connect: Sequence[str], *, find_s: float = FIND_S) -> ZenohBus:
    """An operator's bus in the cell behind these endpoints, linked to all that is up.

    Raises:
        BadInput: an endpoint cannot be used.
        InfrastructureError: nothing is up there, or several cells are.
    """
    found = find_cell(connect, find_s=find_s)
    if found is None:
        raise InfrastructureError(
            f"nothing is up at {_words(connect)}.\n"
            f"  Start a service there: surefetch serve executor --listen {connect[0]}"
        )
    bus = ZenohBus(BusSettings(found.name, connect=found.endpoints))
    wait_for(bus, {status.service for status in found.services})
    return bus


def wait_for(bus: ZenohBus, services: Iterable[str], timeout_s: float = STATUS_S) -> None:
    """Return when all of these services are up, or after the time."""
    wanted, deadline_s = frozenset(services), time.monotonic() + timeout_s
    while not wanted <= bus.alive() and time.monotonic() < deadline_s:
        time.sleep(0.01)


def _statuses(bus: ZenohBus) -> tuple[Status, ...]:
    """What each service says; one that does not answer is left out."""
    wait_for(bus, SERVICES, LINK_S)
    answers = []
    for service in SERVICES:
        if service in bus.alive():
            try:
                answers.append(bus.ask(STATUS[service], Empty(), timeout_s=STATUS_S))
            except SurefetchError:
                continue
    return tuple(answers)


def _reachable(endpoint: str) -> bool:
    """Not one that stands for every address of another host."""
    return not any(wildcard in endpoint for wildcard in _ANY_ADDRESS)


def _words(endpoints: Sequence[str]) -> str:
    return ", ".join(endpoints)
