"""One service on one bus: its work loop, the threads of its concurrent topics, its journal."""

import logging
import os
import queue
import socket
import threading
from collections.abc import Callable
from queue import Full, Queue, SimpleQueue
from typing import Any, Final

from surefetch.common import codec, refusals
from surefetch.common.bus import Call, ServingBus
from surefetch.common.errors import Refused, SurefetchError
from surefetch.common.fatal import or_die
from surefetch.common.hosted import Closes, Ends, Handle, Later, MissesPeers, Service
from surefetch.common.journal import JournalWriter
from surefetch.common.messages import Empty, JournalBytes, JournalPage, RefusedReply, Status
from surefetch.common.topics import JOURNAL, STATUS, Topic, Traffic
from surefetch.common.version import VERSION

log = logging.getLogger(__name__)

MAX_WAITING: Final = 64
"""Questions of one thread; more are refused BUSY."""
LOOK_ROUND_S: Final = 0.2
PAGE_BYTES: Final = 8 * 1024 * 1024


class Host:
    """One service on one bus: threads, queues and the journal around it."""

    def __init__(self, service: Service, bus: ServingBus, journal: JournalWriter) -> None:
        self._service = service
        self._bus = bus
        self._journal = journal
        self._work: SimpleQueue[Callable[[], None]] = SimpleQueue()
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
            # With a timeout: a signal that the kernel gives to a thread of Zenoh's does not wake
            # this one, and Python runs signal handlers in no other.
            try:
                job = self._work.get(timeout=LOOK_ROUND_S)
            except queue.Empty:
                continue
            job()
            del job

    def end(self) -> None:
        """Make the work loop return after what it is doing; returns at once.

        A signal handler may call it, so it takes no lock that the work loop may hold.
        """
        if self._ending.is_set():
            return
        self._ending.set()
        self._work.put(lambda: None)
        if isinstance(self._service, Ends):
            threading.Thread(target=or_die(self._service.end), daemon=True).start()

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
                self._work.put(or_die(lambda: self._serve(handle, call)))

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

        threading.Thread(target=or_die(serve_all), name=handle.topic.name, daemon=True).start()
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
            self._work.put(or_die(later.job))

    def _refuse(self, call: Call, number: int, refusal: RefusedReply) -> None:
        log.info("%s refused: %s", call.topic.name, refusal.text)
        encoded = codec.encode(refusal, max_bytes=len(refusal.text) * 4 + 4096)
        self._journal.write("refusal", call.topic.name, number, encoded)
        call.refuse(refusal)


def _busy(topic: Topic[Any, Any]) -> RefusedReply:
    return refusals.refusal_of(
        Refused(refusals.BUSY, f"{topic.service} has {MAX_WAITING} questions waiting already")
    )
