"""Who is up in a cell, as liveliness tells it, and what an asker makes of what it hears."""

import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from typing import Final, TypeVar

from surefetch.common import codec, refusals
from surefetch.common.errors import InfrastructureError, NoAnswer, PeerMissing
from surefetch.common.messages import Message, RefusedReply
from surefetch.common.topics import Topic

APPEAR_S: Final = 3.0
"""How long an asker waits for a service that it has never seen."""
RETURN_S: Final = 0.5
"""How long for one that went, and after an answer that stayed empty for its token to go."""
MAX_REFUSAL_BYTES: Final = 128 * 1024

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


@dataclass(frozen=True)
class Answered:
    """The other side replied."""

    encoded: bytes


@dataclass(frozen=True)
class Declined:
    """The other side refused, in bytes of a `RefusedReply`."""

    encoded: bytes


@dataclass(frozen=True)
class Finished:
    """No further answer will come."""


@dataclass(frozen=True)
class Gone:
    """The other side's token went."""


@dataclass(frozen=True)
class Closed:
    """This side leaves the bus."""


Heard = Answered | Declined | Finished | Gone | Closed
Hearing = SimpleQueue[Heard]


class Peers:
    """The live processes of a cell; told from the bus's threads, asked from any."""

    def __init__(self, cell: str) -> None:
        self._cell = cell
        self._boots: dict[str, set[str]] = {}
        self._seen: set[str] = set()
        self._changed = threading.Condition()
        self._hearings: dict[str, list[Hearing]] = {}
        self._on_gone: list[Callable[[str], None]] = []
        self._closed = False

    def up(self, service: str, boot: str) -> None:
        """A token is there."""
        with self._changed:
            self._boots.setdefault(service, set()).add(boot)
            self._seen.add(service)
            self._changed.notify_all()

    def down(self, service: str, boot: str) -> None:
        """A token went: whoever waits for that process hears it."""
        with self._changed:
            self._boots.get(service, set()).discard(boot)
            hearings = tuple(self._hearings.get(boot, ()))
            callbacks = tuple(self._on_gone)
            self._changed.notify_all()
        for hearing in hearings:
            hearing.put(Gone())
        for callback in callbacks:
            callback(service)

    def close(self) -> None:
        """Tell everybody who waits that this side leaves."""
        with self._changed:
            self._closed = True
            hearings = [one for several in self._hearings.values() for one in several]
            self._changed.notify_all()
        for hearing in hearings:
            hearing.put(Closed())

    def on_gone(self, callback: Callable[[str], None]) -> None:
        """Call back with the name of every service whose token goes."""
        with self._changed:
            self._on_gone.append(callback)

    def alive(self) -> frozenset[str]:
        """Names of services with a token."""
        with self._changed:
            return frozenset(service for service, boots in self._boots.items() if boots)

    def wait_for(self, service: str, timeout_s: float, *, several: bool = False) -> str:
        """The boot of the one live process of a service; of any of them if there may be several.

        Raises:
            PeerMissing: none came.
            InfrastructureError: there are two, and there may not be.
        """
        with self._changed:
            patience_s = RETURN_S if service in self._seen else APPEAR_S
            deadline_s = time.monotonic() + min(patience_s, timeout_s)
            while not self._closed:
                boots = self._boots.get(service, set())
                if len(boots) == 1 or (boots and several):
                    return next(iter(boots))
                left_s = deadline_s - time.monotonic()
                if left_s <= 0.0:
                    raise self._not_one(service)
                self._changed.wait(left_s)
        raise leaving(service)

    def _not_one(self, service: str) -> InfrastructureError:
        boots = self._boots.get(service, set())
        if boots:
            return InfrastructureError(
                f"{len(boots)} processes called {service} are up in cell {self._cell}; "
                f"stop all but one."
            )
        others = sorted(name for name, several in self._boots.items() if several)
        return PeerMissing(
            service,
            f"{service} is not there: nothing in cell {self._cell} answers for it.\n"
            f"  Up: {', '.join(others) or 'nothing'}\n"
            f"  Start it: surefetch serve {service} --connect ENDPOINT",
        )

    def hear(self, boot: str, hearing: Hearing) -> None:
        """Put `Gone` there when this process goes, also if it is gone already."""
        with self._changed:
            self._hearings.setdefault(boot, []).append(hearing)
            is_up = any(boot in boots for boots in self._boots.values())
        if not is_up:
            hearing.put(Gone())

    def forget(self, boot: str, hearing: Hearing) -> None:
        """Undo `hear`."""
        with self._changed:
            self._hearings[boot].remove(hearing)
            if not self._hearings[boot]:
                del self._hearings[boot]


def leaving(service: str) -> InfrastructureError:
    """The error of an asker whose own side closes."""
    return InfrastructureError(f"this process is leaving the bus; {service} was not asked further.")


def settle(topic: Topic[Q, R], hearing: Hearing, timeout_s: float) -> R:
    """Wait for what decides: a reply, a refusal, death or silence.

    An empty answer does not say what happened, so the token has a moment to tell of a death.

    Raises:
        PeerMissing, NoAnswer, Refused, CodecError, InfrastructureError: as `Bus.ask`.
    """
    deadline_s = time.monotonic() + timeout_s
    finished = False
    for heard in _until(deadline_s, hearing):
        match heard:
            case Answered(encoded=encoded):
                return codec.decode(encoded, topic.reply, max_bytes=topic.max_reply_bytes)
            case Declined(encoded=encoded):
                refusal = codec.decode(encoded, RefusedReply, max_bytes=MAX_REFUSAL_BYTES)
                raise refusals.error_of(refusal)
            case Gone():
                raise PeerMissing(
                    topic.service, f"{topic.service} died while it was asked for {topic.name}."
                )
            case Closed():
                raise leaving(topic.service)
            case Finished():
                finished = True
                break
    if finished:
        _raise_if_gone(topic, hearing)
        raise NoAnswer(topic.service, f"{topic.service} sent no answer to {topic.name}.")
    raise NoAnswer(
        topic.service, f"{topic.service} did not answer {topic.name} within {timeout_s:.1f} s."
    )


def _raise_if_gone(topic: Topic[Q, R], hearing: Hearing) -> None:
    for heard in _until(time.monotonic() + RETURN_S, hearing):
        if isinstance(heard, Gone):
            raise PeerMissing(
                topic.service, f"{topic.service} died while it was asked for {topic.name}."
            )


def _until(deadline_s: float, hearing: Hearing) -> Iterable[Heard]:
    """Everything heard before the deadline, as it comes."""
    while True:
        try:
            yield hearing.get(timeout=max(0.0, deadline_s - time.monotonic()))
        except Empty:
            return
