"""The cell of a run: what is up is used, what is missing is started, and all of it is ended."""

import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from surefetch.common.bus import Bus, ServingBus
from surefetch.common.errors import InfrastructureError
from surefetch.common.joining import FoundCell, find_cell, wait_for
from surefetch.common.launch import Launch, Services, own_cell_name
from surefetch.common.messages import Empty, Status
from surefetch.common.running_cells import RunningCell, announced
from surefetch.common.settings import BusSettings, read_machine
from surefetch.common.topics import SERVICES, STATUS
from surefetch.common.zenoh_bus import ZenohBus

CONFIGURED_FIND_S: Final = 0.6
"""How long to look for services where a configuration says they would listen."""
STATUS_S: Final = 5.0
DEATH_S: Final = 0.5
"""From the end of a liveliness token until the process itself can be seen to have ended."""


@dataclass(frozen=True)
class CellWanted:
    """Which cell to use."""

    config: Path | None = None
    connect: tuple[str, ...] = ()
    real_time: bool = False


@dataclass(frozen=True, eq=False)
class LiveCell:
    """Four services that are up, and this process among them."""

    name: str
    endpoints: tuple[str, ...]
    bus: ServingBus
    statuses: Mapping[str, Status]
    started: Services | None
    """What was started for this run; None: everything was up."""
    folder: Path
    """Journals and logs of what was started."""

    def how_it_died(self, service: str) -> str:
        """Words on the end of a process, if this run has started it."""
        if self.started is None or service not in self.started.pids:
            return ""
        until_s = time.monotonic() + DEATH_S
        while service not in self.started.died() and time.monotonic() < until_s:
            time.sleep(0.01)
        status = self.started.died().get(service)
        if status is None:
            return ""
        return f"killed by signal {-status}" if status < 0 else f"ended with status {status}"

    def last_words(self) -> dict[str, str]:
        """What services wrote at last that this run has started and that have ended."""
        if self.started is None:
            return {}
        return {service: self.started.log_tail(service) for service in self.started.died()}


@contextmanager
def open_cell(wanted: CellWanted, say: Callable[[str], None]) -> Iterator[LiveCell]:
    """The cell that is wanted, until the block ends; `say` hears what is being done.

    Raises:
        BadInput: an endpoint or a configuration cannot be used.
        InfrastructureError: nothing is up at an endpoint, or a service does not start.
    """
    found = _find(wanted)
    name = _name(wanted, found)
    up = () if found is None else tuple(status.service for status in found.services)
    missing = tuple(service for service in SERVICES if service not in up)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="surefetch-run-")))
        started, endpoints = None, () if found is None else found.endpoints
        if missing:
            say(f"starting {', '.join(missing)} …")
            started = Services.start(_launch(wanted, found, name, missing, folder))
            stack.callback(started.close)
            endpoints = (*started.endpoints, *endpoints)
        bus = ZenohBus(BusSettings(name, connect=endpoints))
        stack.callback(bus.close)
        wait_for(bus, SERVICES, STATUS_S)
        statuses = _statuses(bus)
        stack.enter_context(
            announced(
                RunningCell(name=name, endpoints=endpoints, pid=os.getpid(), started_s=time.time())
            )
        )
        yield LiveCell(name, endpoints, bus, statuses, started, folder)


def _find(wanted: CellWanted) -> FoundCell | None:
    if wanted.connect:
        found = find_cell(wanted.connect)
        if found is None:
            raise InfrastructureError(
                f"nothing is up at {', '.join(wanted.connect)}.\n"
                "  Start a service there, or leave out --connect to start all four here."
            )
        return found
    configured = _configured(wanted)
    return find_cell(tuple(configured.values()), find_s=CONFIGURED_FIND_S) if configured else None


def _configured(wanted: CellWanted) -> dict[str, str]:
    """Where a configuration says that each service listens."""
    machine = None if wanted.config is None else read_machine(wanted.config)
    if machine is None or machine.endpoints is None:
        return {}
    return {service: machine.endpoints.of(service) for service in SERVICES}


def _name(wanted: CellWanted, found: FoundCell | None) -> str:
    if found is not None:
        return found.name
    configured = None if wanted.config is None else read_machine(wanted.config).name
    return configured or own_cell_name()


def _launch(
    wanted: CellWanted,
    found: FoundCell | None,
    name: str,
    missing: tuple[str, ...],
    folder: Path,
) -> Launch:
    configured = _configured(wanted)
    options = () if wanted.config is None else ("--config", str(wanted.config.absolute()))
    return Launch(
        services=missing,
        cell=name,
        folder=folder,
        endpoints={service: configured[service] for service in missing} if configured else None,
        connect=() if found is None else found.endpoints,
        options=(*options, *(("--real-time",) if wanted.real_time else ())),
    )


def _statuses(bus: Bus) -> dict[str, Status]:
    return {service: bus.ask(STATUS[service], Empty(), timeout_s=STATUS_S) for service in SERVICES}
