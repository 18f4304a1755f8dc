"""A bus whose user's journal keeps what was said over it."""

from collections.abc import Callable
from typing import TypeVar

from surefetch.common import codec, refusals
from surefetch.common.bus import Bus
from surefetch.common.errors import SurefetchError
from surefetch.common.journal import JournalWriter
from surefetch.common.messages import Message
from surefetch.common.topics import Stream, Topic, Traffic

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


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
