"""A bus within one process, through the real codec: several services, one interpreter."""

import secrets
import threading
from collections.abc import Callable
from typing import Any, TypeVar

from surefetch.common import codec
from surefetch.common.bus import Call, check_may_ask
from surefetch.common.errors import CodecError
from surefetch.common.messages import Message, RefusedReply
from surefetch.common.peers import (
    MAX_REFUSAL_BYTES,
    Answered,
    Declined,
    Hearing,
    Peers,
    settle,
)
from surefetch.common.topics import Stream, Topic, Traffic

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


class LocalCell:
    """What the local buses of one cell share: who is up, who answers, who listens."""

    def __init__(self, name: str = "local") -> None:
        self.name = name
        self.answering: dict[tuple[str, str], Callable[[Call], None]] = {}
        self.listening: dict[str, list[Callable[[bytes], None]]] = {}
        self.lock = threading.Lock()
        self._up: dict[str, str] = {}
        self._peers: list[Peers] = []

    def join(self) -> Peers:
        """A newcomer's view of who is up, kept up to date."""
        peers = Peers(self.name)
        with self.lock:
            self._peers.append(peers)
            for boot, service in self._up.items():
                peers.up(service, boot)
        return peers

    def up(self, service: str, boot: str) -> None:
        """Tell everybody who has come."""
        with self.lock:
            self._up[boot] = service
            for peers in self._peers:
                peers.up(service, boot)

    def down(self, boot: str) -> None:
        """Tell everybody who has gone, if it ever came."""
        with self.lock:
            service = self._up.pop(boot, None)
            everybody = tuple(self._peers)
        if service is not None:
            for peers in everybody:
                peers.down(service, boot)

    def boots(self, service: str) -> tuple[str, ...]:
        """The live processes of a service."""
        with self.lock:
            return tuple(boot for boot, name in self._up.items() if name == service)


class LocalBus:
    """One side of the cell: a service, or with no service's name an operator."""

    def __init__(self, cell: LocalCell, service: str | None = None) -> None:
        self._cell = cell
        self._service = service
        self._boot = secrets.token_hex(16)
        self._peers = cell.join()

    @property
    def cell(self) -> str:
        return self._cell.name

    @property
    def boot(self) -> str:
        return self._boot

    @property
    def endpoints(self) -> tuple[str, ...]:
        return ()

    def ask(self, topic: Topic[Q, R], request: Q, *, timeout_s: float) -> R:
        check_may_ask(self._service, topic)
        encoded = codec.encode(request, max_bytes=topic.max_request_bytes)
        several = topic.traffic is Traffic.STOP
        boot = self._peers.wait_for(topic.service, timeout_s, several=several)
        hearing: Hearing = Hearing()
        self._peers.hear(boot, hearing)
        try:
            for hearer in self._cell.boots(topic.service) if several else (boot,):
                on_call = self._cell.answering.get((hearer, topic.name))
                if on_call is not None:
                    on_call(_LocalCall(topic, encoded, hearing))
            return settle(topic, hearing, timeout_s)
        finally:
            self._peers.forget(boot, hearing)

    def publish(self, stream: Stream[Q], message: Q) -> None:
        encoded = codec.encode(message, max_bytes=stream.max_bytes)
        with self._cell.lock:
            listeners = tuple(self._cell.listening.get(stream.name, ()))
        for on_encoded in listeners:
            on_encoded(encoded)

    def listen(self, stream: Stream[Q], on_message: Callable[[Q], None]) -> None:
        def on_encoded(encoded: bytes) -> None:
            on_message(codec.decode(encoded, stream.message, max_bytes=stream.max_bytes))

        with self._cell.lock:
            self._cell.listening.setdefault(stream.name, []).append(on_encoded)

    def alive(self) -> frozenset[str]:
        return self._peers.alive()

    def answer(self, topic: Topic[Any, Any], on_call: Callable[[Call], None]) -> None:
        self._cell.answering[self._boot, topic.name] = on_call

    def announce(self) -> None:
        if self._service is not None:
            self._cell.up(self._service, self._boot)

    def on_gone(self, callback: Callable[[str], None]) -> None:
        self._peers.on_gone(callback)

    def close(self) -> None:
        self._peers.close()
        self._cell.down(self._boot)


class _LocalCall:
    """A question whose asker sits in another thread."""

    def __init__(self, topic: Topic[Any, Any], encoded: bytes, hearing: Hearing) -> None:
        self.topic = topic
        self.encoded = encoded
        self._hearing = hearing

    def reply(self, encoded: bytes) -> None:
        if len(encoded) > self.topic.max_reply_bytes:
            raise CodecError(f"reply to {self.topic.name} is too large: {len(encoded)} bytes")
        self._hearing.put(Answered(encoded))

    def refuse(self, refusal: RefusedReply) -> None:
        self._hearing.put(Declined(codec.encode(refusal, max_bytes=MAX_REFUSAL_BYTES)))
