"""Serve one service in this process until told to stop: bus, journal, signals, the parent's death.

Wiring, in a service's ``__main__.py``::

    def main(argv: list[str]) -> int:
        settings = read_settings(argv, PLANNER)
        return serve(lambda bus: PlannerService(bus), settings)

What a service is, is told in `hosted`.
"""

import logging
import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from types import FrameType
from typing import Final

from surefetch.common.bus import Bus
from surefetch.common.fatal import die, or_die
from surefetch.common.host import Host
from surefetch.common.hosted import Ends, Handle, Later, Service
from surefetch.common.journal import JournalWriter
from surefetch.common.journaled_bus import JournaledBus
from surefetch.common.settings import Settings
from surefetch.common.zenoh_bus import ZenohBus

__all__ = ["Handle", "Host", "JournaledBus", "Later", "Service", "serve"]

END_S: Final = 0.8
"""From a signal until a work loop that is still busy is given up."""
END_GENTLY_S: Final = 3.0
"""The same for a service that ends its own work, as a controlled stop."""


def serve(make_service: Callable[[Bus], Service], settings: Settings) -> int:
    """Host a service in this process until a signal, or its parent's death, ends it.

    Args:
        make_service: gets the bus on which it may ask and publish.
        settings: from `read_settings`.

    Returns:
        0 after SIGTERM, SIGINT or the parent's end. An unexpected error does not return.

    Raises:
        BadInput: an endpoint or the journal's folder cannot be used.
    """
    logging.basicConfig(
        level=settings.log_level.upper(),
        format=f"%(asctime)s {settings.service} %(levelname)s %(message)s",
    )
    threading.excepthook = lambda _: die()
    with ExitStack() as stack:
        bus = ZenohBus(settings.bus, settings.service)
        stack.callback(bus.close)
        journal = JournalWriter(
            _journal_path(settings, bus.boot, stack), settings.service, bus.boot
        )
        service = make_service(JournaledBus(bus, journal))
        host = Host(service, bus, journal)
        stack.callback(host.close)
        _end_on_signals(host, isinstance(service, Ends))
        if settings.parent_pid is not None:
            _end_with(settings.parent_pid)
        host.announce()
        _say_ready(settings, bus)
        or_die(host.work)()
    return 0


def _journal_path(settings: Settings, boot: str, stack: ExitStack) -> Path:
    """In the folder that was named, else in one that goes when the process ends."""
    folder = settings.journal_dir
    if folder is None:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="surefetch-")))
    return folder / f"{settings.service}-{boot[:8]}.journal"


def _end_on_signals(host: Host, gently: bool) -> None:
    """The first signal ends the work loop, in bounded time; the second one ends at once."""

    def on_signal(_number: int, _frame: FrameType | None) -> None:
        signal.signal(signal.SIGTERM, lambda *_: os._exit(0))
        signal.signal(signal.SIGINT, lambda *_: os._exit(0))
        timer = threading.Timer(END_GENTLY_S if gently else END_S, lambda: os._exit(0))
        timer.daemon = True
        timer.start()
        host.end()

    signal.signal(signal.SIGTERM, on_signal)
    signal.signal(signal.SIGINT, on_signal)


def _end_with(parent_pid: int) -> None:
    """Send ourselves SIGTERM when that process is no longer our parent."""

    def watch() -> None:
        while os.getppid() == parent_pid:
            time.sleep(0.2)
        os.kill(os.getpid(), signal.SIGTERM)

    threading.Thread(target=watch, name="parent", daemon=True).start()


def _say_ready(settings: Settings, bus: ZenohBus) -> None:
    where = ", ".join(settings.bus.listen)
    print(f"surefetch {settings.service} ready at {where} in cell {bus.cell}", flush=True)
