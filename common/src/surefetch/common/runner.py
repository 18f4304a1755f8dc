"""Serve one service until told to stop: the only place that knows threads, signals and the bus.

A service is an object that knows neither. Its `handles` say which topic is answered by which
method. One after another they are run by the work loop, in the process's main thread. What must be
answered while the work loop is busy (a frame, a stop, an instruction) says `concurrent=True` and
gets a thread of its topic's own; such a method must not touch what the work loop changes.

A method that starts something long returns `Later(reply, job)`: the reply leaves at once, and the
job runs in the work loop. So the planner::

    class PlannerService:
        name, backend = PLANNER, "expectimax"

        @property
        def handles(self) -> tuple[Handle[Any, Any], ...]:
            return (
                Handle(INSTRUCT, self.instruct, concurrent=True),
                Handle(CANCEL, self.cancel, concurrent=True),
            )

        def instruct(self, request: Instruct) -> Later[Accepted]:
            if not self._free.acquire(blocking=False):
                raise Refused("BUSY", "an episode is running; cancel it first")
            accepted = self._understand(request)
            return Later(accepted, lambda: self._run_episode(accepted))

A method refuses by raising a `SurefetchError`, which the asker meets again. Any other exception
ends the process with status 70: a service whose state is in doubt must not serve on. Wiring, in the
service's ``__main__.py``::

    def main(argv: list[str]) -> int:
        settings = read_settings(argv, PLANNER)
        return serve(lambda bus: PlannerService(bus), settings)
"""

import logging
import os
import signal
import socket
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from queue import Full, Queue
from types import FrameType
from typing import Any, Final, Generic, Protocol, TypeVar, runtime_checkable

from surefetch.common import codec, refusals
from surefetch.common.bus import Bus, Call, ServingBus
from surefetch.common.errors import Refused, SurefetchError
from surefetch.common.journal import JournalWriter
from surefetch.common.messages import (
    Empty,
    JournalBytes,
    JournalPage,
    Message,
    RefusedReply,
    Status,
)
from surefetch.common.settings import Settings
from surefetch.common.topics import JOURNAL, STATUS, Stream, Topic, Traffic
from surefetch.common.version import VERSION
from surefetch.common.zenoh_bus import ZenohBus

log = logging.getLogger(__name__)

MAX_WAITING: Final = 64
"""Questions of one thread; more are refused BUSY."""
PAGE_BYTES: Final = 8 * 1024 * 1024
END_S: Final = 0.8
"""From a signal until a work loop that is still busy is given up."""
END_GENTLY_S: Final = 3.0
"""The same for a service that ends its own work, as a controlled stop."""
UNEXPECTED: Final = 70

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


@dataclass(frozen=True)
class Later(Generic[R]):
    """A reply that leaves now, and work that the work loop does after it."""

    reply: R
    job: Callable[[], None]


@dataclass(frozen=True)
class Handle(Generic[Q, R]):
    """Which method answers a topic."""

    topic: Topic[Q, R]
    answer: Callable[[Q], R | Later[R]]
    concurrent: bool = False
    """Answered by the topic's own thread, also while the work loop is busy."""


class Service(Protocol):
    """What the runner hosts."""

    @property
    def name(self) -> str: ...

    @property
    def backend(self) -> str:
        """Which implementation runs: `pybullet`, `classical` and so on."""
        ...

    @property
    def doing(self) -> str:
        """In a few words, for `surefetch status`; read from another thread."""
        ...

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        """Every topic it answers, status and journal aside."""
        ...


@runtime_checkable
class MissesPeers(Protocol):
    """A service that wants to know when another one dies."""

    def peer_gone(self, service: str) -> None:
        """Called from a thread of the bus; must return at once."""
        ...


@runtime_checkable
class Ends(Protocol):
    """A service that has something to bring to rest."""

    def end(self) -> None:
        """The process was told to end: make the work under way come to its end soon.

        Called once, from another thread than the work loop's; the work loop has 3 s from then on.
        """
        ...


@runtime_checkable
class Closes(Protocol):
    """A service that holds something to give back."""

    def close(self) -> None:
        """Called last, in the work loop's thread."""
        ...


class Host:
    """One service on one bus: threads, queues and the journal around it."""

    def __init__(self, service: Service, bus: ServingBus, journal: JournalWriter) -> None:
        self._service = service
        self._bus = bus
        self._journal = journal
        self._work: Queue[Callable[[], None] | None] = Queue()
        self._ending = threading.Event()
        self._n_served = 0

    def announce(self) -> None:
        """Answer all topics from now on, then be found."""
        for handle in (*self._service.handles, *self._own_handles()):
            enqueue = self._thread_of(handle) if handle.concurrent else self._into_work(handle)
            self._bus.answer(handle.topic, enqueue)
        if isinstance(self._service, MissesPeers):
            self._bus.on_gone(self._service.peer_gone)
        self._bus.announce()

    def work(self) -> None:
        """The work loop; returns after `end`."""
        while not self._ending.is_set():
            job = self._work.get()
            if job is not None:
                job()
            del job

    def end(self) -> None:
        """Make the work loop return after what it is doing; returns at once."""
        if self._ending.is_set():
            return
        self._ending.set()
        self._work.put(None)
        if isinstance(self._service, Ends):
            threading.Thread(target=_or_die(self._service.end), daemon=True).start()

    def close(self) -> None:
        """Leave the bus and let the service give back what it holds."""
        self._bus.close()
        if isinstance(self._service, Closes):
            self._service.close()
        self._journal.close()

    def _own_handles(self) -> tuple[Handle[Any, Any], ...]:
        name = self._service.name
        return (
            Handle(STATUS[name], self._status, concurrent=True),
            Handle(JOURNAL[name], self._journal_page, concurrent=True),
        )

    def _status(self, _: Empty) -> Status:
        return Status(
            service=self._service.name,
            boot=self._bus.boot,
            pid=os.getpid(),
            host=socket.gethostname() or "unknown",
            version=VERSION,
            backend=self._service.backend,
            doing=self._service.doing,
            n_served=self._n_served,
            endpoints=self._bus.endpoints,
        )

    def _journal_page(self, request: JournalPage) -> JournalBytes:
        content, total = self._journal.page(request.offset, PAGE_BYTES)
        return JournalBytes(offset=request.offset, content=content, total=total)

    def _into_work(self, handle: Handle[Any, Any]) -> Callable[[Call], None]:
        def on_call(call: Call) -> None:
            if self._work.qsize() >= MAX_WAITING:
                call.refuse(_busy(handle.topic))
            else:
                self._work.put(_or_die(lambda: self._serve(handle, call)))

        return on_call

    def _thread_of(self, handle: Handle[Any, Any]) -> Callable[[Call], None]:
        waiting: Queue[Call] = Queue(MAX_WAITING)

        def serve_all() -> None:
            try:
                while True:
                    self._serve(handle, waiting.get())
            except BaseException:
                if not self._ending.is_set():  # else the bus and the service are closing under it
                    raise
                log.info("%s: a question met the end of the process", handle.topic.name)

        def on_call(call: Call) -> None:
            try:
                waiting.put_nowait(call)
            except Full:
                call.refuse(_busy(handle.topic))

        threading.Thread(target=_or_die(serve_all), name=handle.topic.name, daemon=True).start()
        return on_call

    def _serve(self, handle: Handle[Any, Any], call: Call) -> None:
        """Answer one question, exactly once; run what it leaves to do in the work loop."""
        topic = handle.topic
        number = self._journal.new_call()
        journaled = topic.traffic is not Traffic.BULK and topic.verb != "status"
        try:
            request = codec.decode(call.encoded, topic.request, max_bytes=topic.max_request_bytes)
            if journaled:
                self._journal.write("request", topic.name, number, call.encoded)
            answer = handle.answer(request)
            later = answer if isinstance(answer, Later) else None
            reply = answer.reply if isinstance(answer, Later) else answer
            encoded = codec.encode(reply, max_bytes=topic.max_reply_bytes)
        except SurefetchError as error:
            self._refuse(call, number, refusals.refusal_of(error))
            return
        if journaled:
            self._journal.write("reply", topic.name, number, encoded)
        call.reply(encoded)
        self._n_served += 1
        if later is not None:
            self._work.put(_or_die(later.job))

    def _refuse(self, call: Call, number: int, refusal: RefusedReply) -> None:
        log.info("%s refused: %s", call.topic.name, refusal.text)
        encoded = codec.encode(refusal, max_bytes=len(refusal.text) * 4 + 4096)
        self._journal.write("refusal", call.topic.name, number, encoded)
        call.refuse(refusal)


class JournaledBus:
    """A bus that also keeps what was asked, answered and published over it; bulk data aside."""

    def __init__(self, bus: Bus, journal: JournalWriter) -> None:
        self._bus = bus
        self._journal = journal

    @property
    def boot(self) -> str:
        return self._bus.boot

    def ask(self, topic: Topic[Q, R], request: Q, *, timeout_s: float) -> R:
        if topic.traffic is Traffic.BULK:
            return self._bus.ask(topic, request, timeout_s=timeout_s)
        number = self._journal.new_call()
        asked = codec.encode(request, max_bytes=topic.max_request_bytes)
        self._journal.write("ask", topic.name, number, asked)
        try:
            reply = self._bus.ask(topic, request, timeout_s=timeout_s)
        except SurefetchError as error:
            refusal = refusals.refusal_of(error)
            encoded = codec.encode(refusal, max_bytes=len(refusal.text) * 4 + 4096)
            self._journal.write("failure", topic.name, number, encoded)
            raise
        answered = codec.encode(reply, max_bytes=topic.max_reply_bytes)
        self._journal.write("answer", topic.name, number, answered)
        return reply

    def publish(self, stream: Stream[Q], message: Q) -> None:
        if stream.journaled:
            encoded = codec.encode(message, max_bytes=stream.max_bytes)
            self._journal.write("event", stream.name, 0, encoded)
        self._bus.publish(stream, message)

    def listen(self, stream: Stream[Q], on_message: Callable[[Q], None]) -> None:
        self._bus.listen(stream, on_message)

    def alive(self) -> frozenset[str]:
        return self._bus.alive()


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
    threading.excepthook = lambda _: _die()
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
        _or_die(host.work)()
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


def _busy(topic: Topic[Any, Any]) -> RefusedReply:
    return refusals.refusal_of(
        Refused(refusals.BUSY, f"{topic.service} has {MAX_WAITING} questions waiting already")
    )


def _or_die(job: Callable[[], None]) -> Callable[[], None]:
    """The job, but an unexpected error ends the process."""

    def guarded() -> None:
        try:
            job()
        except BaseException:
            _die()

    return guarded


def _die() -> None:
    log.critical("unexpected error; the process ends", exc_info=True)
    logging.shutdown()
    sys.stdout.flush()
    os._exit(UNEXPECTED)
