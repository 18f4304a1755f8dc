"""The bus as services see it: ask, publish, listen. Implementations: `LocalBus`, `ZenohBus`."""

from collections.abc import Callable
from typing import Protocol, TypeVar

from surefetch.common.messages import Message
from surefetch.common.topics import Stream, Topic

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


class Bus(Protocol):
    """Typed questions and streams between services of one cell."""

    def ask(self, topic: Topic[Q, R], request: Q, *, timeout_s: float) -> R:
        """The one reply of the one live service that answers the topic.

        Raises:
            PeerMissing: the service is not there, or died while it was asked; names it.
            NoAnswer: it is there but did not answer in time.
            Refused: it answered no.
            CodecError: its answer is no valid message.
        """
        ...

    def publish(self, stream: Stream[Q], message: Q) -> None:
        """Give a message to whoever listens; never blocks for long, needs no listener."""
        ...

    def listen(self, stream: Stream[Q], on_message: Callable[[Q], None]) -> None:
        """Call back for every message of the stream, from a thread of the bus."""
        ...

    def alive(self) -> frozenset[str]:
        """Names of the services whose liveliness tokens are up."""
        ...
