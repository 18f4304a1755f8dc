"""The bus as services see it: ask, publish, listen. Implementations: `LocalBus`, `ZenohBus`."""

from collections.abc import Callable
from typing import Any, Protocol, TypeVar

from surefetch.common.messages import Message, RefusedReply
from surefetch.common.topics import Stream, Topic

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


class Bus(Protocol):
    """Typed questions and streams between services of one cell."""

    @property
    def boot(self) -> str:
        """This process's identity: 128 random bits in hexadecimal digits."""
        ...

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


class Call(Protocol):
    """One question that waits for its answer; it must get exactly one."""

    @property
    def topic(self) -> Topic[Any, Any]: ...

    @property
    def encoded(self) -> bytes:
        """The request as it travelled; within the topic's size, not yet decoded."""
        ...

    def reply(self, encoded: bytes) -> None:
        """Answer with an encoded reply."""
        ...

    def refuse(self, refusal: RefusedReply) -> None:
        """Answer no."""
        ...


class ServingBus(Bus, Protocol):
    """What the runner needs on top: to answer, to be found, and to see others go."""

    @property
    def cell(self) -> str:
        """The cell's name in keys."""
        ...

    @property
    def endpoints(self) -> tuple[str, ...]:
        """Where it listens, then whom it connects to."""
        ...

    def answer(self, topic: Topic[Any, Any], on_call: Callable[[Call], None]) -> None:
        """Give every question of a topic to `on_call`, which only checks and enqueues."""
        ...

    def announce(self) -> None:
        """Be found from now on; after all topics are answered."""
        ...

    def on_gone(self, callback: Callable[[str], None]) -> None:
        """Call back with a service's name when its liveliness token goes; must return at once."""
        ...

    def close(self) -> None:
        """Leave: questions under way end with an error on both sides."""
        ...


def check_may_ask(service: str | None, topic: Topic[Any, Any]) -> None:
    """A service asks only what the table says; an operator or scorer (None) is not told apart.

    Raises:
        RuntimeError: a service asks what is not for it, as where an object really is. That is an
            error in its code, so it is no refusal.
    """
    if service is not None and service not in topic.senders:
        who = ", ".join(topic.senders)
        raise RuntimeError(f"{service} may not ask {topic.name}; the table of topics says: {who}")
