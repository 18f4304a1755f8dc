"""A bus whose questions end at once when any service that the episode needs dies.

Asking one service can take as long as a motion does. If another one dies meanwhile, the episode is
lost already, and waiting for the answer would only delay saying so.
"""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

from surefetch.common.bus import Bus
from surefetch.common.errors import PeerMissing
from surefetch.common.messages import Message
from surefetch.common.topics import Stream, Topic

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


class PromptBus:
    """Same face as the bus; a question under way is abandoned, its answer still journaled."""

    def __init__(self, bus: Bus, needed: frozenset[str]) -> None:
        self._bus = bus
        self._needed = needed
        self._gone: str | None = None
        self._changed = threading.Condition()

    @property
    def boot(self) -> str:
        return self._bus.boot

    def begin(self) -> None:
        """Forget who died before."""
        with self._changed:
            self._gone = None

    def peer_gone(self, service: str) -> None:
        """End the question under way, if this service is needed; returns at once."""
        if service in self._needed:
            with self._changed:
                self._gone = self._gone or service
                self._changed.notify_all()

    def ask(self, topic: Topic[Q, R], request: Q, *, timeout_s: float) -> R:
        self._check_all_there(topic)
        answer: Future[R] = Future()
        answer.add_done_callback(self._notify)
        threading.Thread(
            target=_settle,
            args=(answer, lambda: self._bus.ask(topic, request, timeout_s=timeout_s)),
            name=topic.name,
            daemon=True,
        ).start()
        with self._changed:
            self._changed.wait_for(lambda: answer.done() or self._gone is not None)
        if not answer.done():
            self._check_all_there(topic)
        return answer.result()

    def publish(self, stream: Stream[Q], message: Q) -> None:
        self._bus.publish(stream, message)

    def listen(self, stream: Stream[Q], on_message: Callable[[Q], None]) -> None:
        self._bus.listen(stream, on_message)

    def alive(self) -> frozenset[str]:
        return self._bus.alive()

    def _check_all_there(self, topic: Topic[Q, R]) -> None:
        with self._changed:
            gone = self._gone
        if gone is not None:
            raise PeerMissing(gone, f"{gone} died; {topic.name} is not asked any further.")

    def _notify(self, _: object) -> None:
        with self._changed:
            self._changed.notify_all()


def _settle(answer: "Future[R]", ask: Callable[[], R]) -> None:
    """Whatever comes of it is raised again in the thread that waits."""
    try:
        answer.set_result(ask())
    except BaseException as error:
        answer.set_exception(error)
