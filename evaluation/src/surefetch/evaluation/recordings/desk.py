"""A bus within one call: a question goes straight to whoever answers it, in the same thread."""

from collections.abc import Callable, Iterable
from typing import Any, TypeVar, cast

from surefetch.common.messages import Message
from surefetch.common.runner import Handle
from surefetch.common.topics import Stream, Topic

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


class Desk:
    """Services of one process side by side. What is published here, nobody hears."""

    def __init__(self, boot: str) -> None:
        self._boot = boot
        self._answering: dict[str, Callable[[Any], Any]] = {}

    def seat(self, handles: Iterable[Handle[Any, Any]]) -> None:
        """Let a service answer its topics."""
        self._answering |= {one.topic.name: one.answer for one in handles}

    @property
    def boot(self) -> str:
        return self._boot

    def ask(self, topic: Topic[Q, R], request: Q, *, timeout_s: float) -> R:  # noqa: ARG002
        return cast(R, self._answering[topic.name](request))

    def publish(self, stream: Stream[Q], message: Q) -> None:
        """To nobody."""

    def listen(self, stream: Stream[Q], on_message: Callable[[Q], None]) -> None:
        """To nothing."""

    def alive(self) -> frozenset[str]:
        return frozenset()
