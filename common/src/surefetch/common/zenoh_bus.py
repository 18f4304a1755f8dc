"""A bus between processes and machines, over Zenoh: a full mesh of named links, no router.

What Zenoh does in each case of a question (an empty answer, a death, a second queryable on one key,
an exception in a callback) was measured, and decides how things are done here: keys hold the
service's boot, handlers refuse a key that is not literally theirs, every query is finalised at
once, and an exception in a callback ends the process, since no hook would see it.
"""

import json
import logging
import re
import secrets
import threading
import time
from collections.abc import Callable
from typing import Any, Final, TypeVar

import zenoh

from surefetch.common import codec, refusals
from surefetch.common.bus import Call, check_may_ask
from surefetch.common.errors import BadInput, CodecError
from surefetch.common.fatal import die
from surefetch.common.messages import Message, RefusedReply
from surefetch.common.peers import (
    MAX_REFUSAL_BYTES,
    Answered,
    Declined,
    Finished,
    Hearing,
    Peers,
    settle,
)
from surefetch.common.settings import BusSettings
from surefetch.common.topics import Stream, Topic, Traffic

log = logging.getLogger(__name__)

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)

LEASE_MS: Final = 2000
"""A cut link or a stopped process is noticed after this; a killed one within milliseconds."""
MAX_MESSAGE_BYTES: Final = 80 * 1024 * 1024
MATCH_S: Final = 1.0

PRIORITY: Final = {
    Traffic.STOP: zenoh.Priority.REAL_TIME,
    Traffic.COMMAND: zenoh.Priority.INTERACTIVE_HIGH,
    Traffic.DECISION: zenoh.Priority.DATA_HIGH,
    Traffic.EVENT: zenoh.Priority.DATA,
    Traffic.BULK: zenoh.Priority.DATA_LOW,
}
EXPRESS: Final = frozenset({Traffic.STOP, Traffic.COMMAND})


class ZenohBus:
    """One process's place on the bus; `service` is None for an operator, who answers nothing."""

    def __init__(self, settings: BusSettings, service: str | None = None) -> None:
        """Open the links.

        Raises:
            BadInput: an endpoint cannot be used.
        """
        self._settings = settings
        self._service = service
        self._boot = secrets.token_hex(16)
        self._peers = Peers(settings.cell)
        self._matched: set[str] = set()
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._lock = threading.Lock()
        self._token: zenoh.LivelinessToken | None = None
        self._session = _open(settings)
        self._session.liveliness().declare_subscriber(
            f"cell/{settings.cell}/live/*/*", _fatal(self._on_liveliness), history=True
        )

    @property
    def cell(self) -> str:
        return self._settings.cell

    @property
    def boot(self) -> str:
        return self._boot

    @property
    def endpoints(self) -> tuple[str, ...]:
        return self._settings.listen + self._settings.connect

    def ask(self, topic: Topic[Q, R], request: Q, *, timeout_s: float) -> R:
        check_may_ask(self._service, topic)
        encoded = codec.encode(request, max_bytes=topic.max_request_bytes)
        several = topic.traffic is Traffic.STOP
        boot = self._peers.wait_for(topic.service, timeout_s, several=several)
        hearing: Hearing = Hearing()
        cancel = zenoh.CancellationToken()
        self._peers.hear(boot, hearing)
        try:
            self._get(topic, self._key(topic, boot), encoded, hearing, cancel, timeout_s)
            return settle(topic, hearing, timeout_s)
        finally:
            self._peers.forget(boot, hearing)
            cancel.cancel()  # type: ignore[no-untyped-call]

    def _get(
        self,
        topic: Topic[Any, Any],
        key: str,
        encoded: bytes,
        hearing: Hearing,
        cancel: zenoh.CancellationToken,
        timeout_s: float,
    ) -> None:
        def on_reply(reply: zenoh.Reply) -> None:
            _hear(reply, hearing)

        self._wait_until_matched(key)
        self._session.get(
            key,
            zenoh.handlers.Callback(_fatal(on_reply), lambda: hearing.put(Finished())),
            target=zenoh.QueryTarget.ALL if topic.traffic is Traffic.STOP else None,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=timeout_s + 1.0,
            priority=PRIORITY[topic.traffic],
            express=topic.traffic in EXPRESS,
            payload=encoded,
            encoding=_encoding(topic.request),
            cancellation_token=cancel,
        )

    def _wait_until_matched(self, key: str) -> None:
        """A token can be seen a moment before the queryables; asked then, nobody would answer."""
        if key in self._matched:
            return
        deadline_s = time.monotonic() + MATCH_S
        with self._session.declare_querier(key) as querier:
            while not _is_matched(querier) and time.monotonic() < deadline_s:
                time.sleep(0.001)
        self._matched.add(key)

    def publish(self, stream: Stream[Q], message: Q) -> None:
        encoded = codec.encode(message, max_bytes=stream.max_bytes)
        with self._lock:
            if stream.name not in self._publishers:
                self._publishers[stream.name] = self._session.declare_publisher(
                    f"cell/{self.cell}/{stream.service}/{self._boot}/{stream.verb}",
                    encoding=_encoding(stream.message),
                    congestion_control=zenoh.CongestionControl.DROP,
                    priority=PRIORITY[Traffic.EVENT],
                )
        self._publishers[stream.name].put(encoded)

    def listen(self, stream: Stream[Q], on_message: Callable[[Q], None]) -> None:
        def on_sample(sample: zenoh.Sample) -> None:
            if len(sample.payload) > stream.max_bytes:
                log.warning(
                    "%s: a message of %d bytes is dropped", stream.name, len(sample.payload)
                )
                return
            try:
                encoded = sample.payload.to_bytes()
                message = codec.decode(encoded, stream.message, max_bytes=stream.max_bytes)
            except CodecError as error:
                log.warning("%s: a message is dropped: %s", stream.name, error)
                return
            on_message(message)

        key = f"cell/{self.cell}/{stream.service}/*/{stream.verb}"
        self._session.declare_subscriber(key, _fatal(on_sample))

    def alive(self) -> frozenset[str]:
        return self._peers.alive()

    def answer(self, topic: Topic[Any, Any], on_call: Callable[[Call], None]) -> None:
        key = self._key(topic, self._boot)

        def on_query(query: zenoh.Query) -> None:
            call = _check(query, key, topic)
            if call is not None:
                on_call(call)

        self._session.declare_queryable(key, _fatal(on_query), complete=True)

    def announce(self) -> None:
        if self._service is not None:
            key = f"cell/{self.cell}/live/{self._service}/{self._boot}"
            self._token = self._session.liveliness().declare_token(key)

    def on_gone(self, callback: Callable[[str], None]) -> None:
        self._peers.on_gone(callback)

    def close(self) -> None:
        self._peers.close()
        self._session.close()  # type: ignore[no-untyped-call]

    def _key(self, topic: Topic[Any, Any], boot: str) -> str:
        if topic.traffic is Traffic.STOP:
            return f"cell/{self.cell}/{topic.service}/{topic.verb}"
        return f"cell/{self.cell}/{topic.service}/{boot}/{topic.verb}"

    def _on_liveliness(self, sample: zenoh.Sample) -> None:
        *_, service, boot = str(sample.key_expr).split("/")
        if sample.kind == zenoh.SampleKind.PUT:
            self._peers.up(service, boot)
        else:
            self._peers.down(service, boot)


class _ZenohCall:
    """A query under way; answering it finalises it, so that the asker is released at once."""

    def __init__(self, topic: Topic[Any, Any], encoded: bytes, query: zenoh.Query) -> None:
        self.topic = topic
        self.encoded = encoded
        self._query = query

    def reply(self, encoded: bytes) -> None:
        with self._query as query:
            query.reply(query.key_expr, encoded, encoding=_encoding(self.topic.reply))

    def refuse(self, refusal: RefusedReply) -> None:
        _refuse(self._query, refusal)


def live_cells(endpoints: tuple[str, ...], timeout_s: float) -> dict[str, frozenset[str]]:
    """Names of the cells with a service up behind these endpoints, and those services.

    Returns when nothing new was seen for a moment, or after the time with what there is.

    Raises:
        BadInput: an endpoint cannot be used.
    """
    found: dict[str, set[str]] = {}
    seen = threading.Event()

    def on_token(sample: zenoh.Sample) -> None:
        _, cell, _, service, _ = str(sample.key_expr).split("/")
        if sample.kind == zenoh.SampleKind.PUT:
            found.setdefault(cell, set()).add(service)
            seen.set()

    session = _open(BusSettings(cell="unknown", connect=endpoints))
    try:
        session.liveliness().declare_subscriber("cell/*/live/*/*", _fatal(on_token), history=True)
        if seen.wait(timeout_s):
            time.sleep(0.2)
    finally:
        session.close()  # type: ignore[no-untyped-call]
    return {cell: frozenset(services) for cell, services in found.items()}


def _open(settings: BusSettings) -> zenoh.Session:
    try:
        return zenoh.open(zenoh.Config.from_json5(json.dumps(_config(settings))))
    except zenoh.ZError as error:
        used = [*(f"--listen {e}" for e in settings.listen)]
        used += [*(f"--connect {e}" for e in settings.connect)]
        raise BadInput(
            f"these endpoints cannot be used: {' '.join(used)}\n"
            f"  {_first_line(error)}\n"
            f"  Is another process listening there? An endpoint looks like tcp/127.0.0.1:7447."
        ) from None


def _first_line(error: BaseException) -> str:
    """Without the place in Zenoh's own sources."""
    text = re.split(r" at /\S+\.rs:", str(error).partition("\n")[0])[0]
    return text[:400] or type(error).__name__


def _config(settings: BusSettings) -> dict[str, Any]:
    """No discovery, no router: only the endpoints that the settings name."""
    return {
        "mode": "peer",
        "scouting": {
            "delay": 0,
            "multicast": {"enabled": False},
            "gossip": {"enabled": False},
        },
        "listen": {"endpoints": settings.listen},
        "connect": {
            "endpoints": settings.connect,
            "retry": {
                "period_init_ms": 50,
                "period_max_ms": 200,
                "period_increase_factor": 1.5,
            },
        },
        "transport": {
            "link": {
                "tx": {
                    "lease": LEASE_MS,
                    # An event waits up to 100 ms for room before it is dropped.
                    "queue": {"congestion_control": {"drop": {"wait_before_drop": 100_000}}},
                },
                "rx": {"max_message_size": MAX_MESSAGE_BYTES},
            },
            "shared_memory": {"enabled": settings.shared_memory},
        },
    }


def _is_matched(querier: zenoh.Querier) -> bool:
    status: Any = querier.matching_status  # its annotation says bool, which it is not
    return bool(status.matching)


def _encoding(message: type[Message]) -> str:
    return f"application/msgpack;{message.__name__}.v{codec.WIRE_VERSION}"


REFUSAL: Final = zenoh.Encoding(_encoding(RefusedReply))


def _check(query: zenoh.Query, key: str, topic: Topic[Any, Any]) -> Call | None:
    """The call in a query; None if it was refused, for its key or its size."""
    asked = str(query.key_expr)
    if asked != key:
        text = f"{topic.name} is answered at {key} only, not at {asked[:200]}"
        _refuse(query, RefusedReply(reason=refusals.BAD_KEY, text=text))
        return None
    n_bytes = 0 if query.payload is None else len(query.payload)
    if n_bytes > topic.max_request_bytes:
        text = f"{topic.name}: {n_bytes} bytes, and at most {topic.max_request_bytes} are allowed"
        _refuse(query, RefusedReply(reason=refusals.BAD_SCHEMA, text=text))
        return None
    encoded = b"" if query.payload is None else query.payload.to_bytes()
    return _ZenohCall(topic, encoded, query)


def _refuse(query: zenoh.Query, refusal: RefusedReply) -> None:
    with query:
        query.reply_err(codec.encode(refusal, max_bytes=MAX_REFUSAL_BYTES), encoding=REFUSAL)


def _hear(reply: zenoh.Reply, hearing: Hearing) -> None:
    """Pass on what the service itself said; Zenoh's own errors say nothing that settles."""
    if reply.ok is not None:
        hearing.put(Answered(reply.ok.payload.to_bytes()))
    elif reply.err is not None and reply.err.encoding == REFUSAL:
        hearing.put(Declined(reply.err.payload.to_bytes()))


T = TypeVar("T")


def _fatal(callback: Callable[[T], None]) -> Callable[[T], None]:
    """The callback, but an exception ends the process: Zenoh would swallow it and serve on."""

    def guarded(value: T) -> None:
        try:
            callback(value)
        except BaseException:
            die()

    return guarded
