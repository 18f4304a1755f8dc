"""A running cell, as the command line and any other program use it."""

import logging
import queue
from collections.abc import Iterator
from typing import Final, Literal, Self

from surefetch.common.bus import Bus
from surefetch.common.errors import PeerMissing, SurefetchError
from surefetch.common.joining import join
from surefetch.common.messages import (
    Accepted,
    Cancel,
    Empty,
    Ended,
    Event,
    Instruct,
    JournalPage,
    Status,
    Stop,
    Stopped,
)
from surefetch.common.policies import choose
from surefetch.common.topics import (
    CANCEL,
    EVENTS,
    INSTRUCT,
    JOURNAL,
    PLANNER,
    SERVICES,
    STATUS,
    STOP,
)
from surefetch.common.zenoh_bus import ZenohBus

log = logging.getLogger(__name__)

AfterGrasp = Literal["deliver", "hold", "return"]

ANSWER_S: Final = 10.0
STOP_S: Final = 5.0
_LOOK_ROUND_S: Final = 0.1


class Cell:
    """Fetch, follow, cancel and stop in one running cell. One episode at a time.

    Every method raises what `Bus.ask` raises: `PeerMissing` and `NoAnswer` name the service,
    `Refused` is the service's own no.
    """

    def __init__(self, *endpoints: str) -> None:
        """Join the cell behind these endpoints; one leads to all others.

        Raises:
            BadInput: an endpoint cannot be used.
            InfrastructureError: nothing is up there.
        """
        self._own_bus: ZenohBus | None = join(endpoints)
        self._use(self._own_bus)

    @classmethod
    def on(cls, bus: Bus) -> Self:
        """The same over a bus that is there already, and stays open."""
        cell = cls.__new__(cls)
        cell._own_bus = None
        cell._use(bus)
        return cell

    def _use(self, bus: Bus) -> None:
        self._bus = bus
        self._heard: queue.SimpleQueue[Event] = queue.SimpleQueue()
        bus.listen(EVENTS, self._heard.put)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the cell; an episode under way goes on."""
        if self._own_bus is not None:
            self._own_bus.close()

    @property
    def bus(self) -> Bus:
        """For what this class does not do."""
        return self._bus

    def fetch(
        self,
        sentence: str,
        *,
        profile: str | None = None,
        policy: str | None = None,
        after_grasp: AfterGrasp = "deliver",
    ) -> Iterator[Event]:
        """Fetch what the sentence names; the episode's events, the last of which is `Ended`.

        Leaving the loop early cancels the episode, which ends after the motion under way.
        """
        accepted = self.instruct(sentence, profile=profile, policy=policy, after_grasp=after_grasp)
        return self._until_left(accepted.episode)

    def instruct(
        self,
        sentence: str,
        *,
        profile: str | None = None,
        policy: str | None = None,
        after_grasp: AfterGrasp = "deliver",
    ) -> Accepted:
        """Begin an episode. Profile and policy complete each other; by default, `extended`.

        Raises:
            BadInput: there is no such profile or policy, or they do not go together.
        """
        profile, policy = choose(profile, policy)
        request = Instruct(
            sentence=sentence, profile=profile, policy=policy, after_grasp=after_grasp
        )
        return self._bus.ask(INSTRUCT, request, timeout_s=ANSWER_S)

    def events(self, episode: str) -> Iterator[Event]:
        """The events of an episode that this client began, until it has ended.

        Raises:
            PeerMissing: the planner died.
        """
        expected = 0
        while True:
            event = self._next()
            if event.episode != episode:
                continue
            if event.seq != expected:
                log.warning("%d events of %s were lost", event.seq - expected, episode)
            expected = event.seq + 1
            yield event
            if isinstance(event.happening, Ended):
                return

    def cancel(self, episode: str) -> None:
        """End an episode as stopped, after the motion under way."""
        self._bus.ask(CANCEL, Cancel(episode=episode), timeout_s=ANSWER_S)

    def stop(self, who: str = "client") -> Stopped:
        """End all motion now."""
        return self._bus.ask(STOP, Stop(who=who), timeout_s=STOP_S)

    def status(self) -> tuple[Status, ...]:
        """What each service that is up says of itself."""
        alive = self._bus.alive()
        return tuple(
            self._bus.ask(STATUS[service], Empty(), timeout_s=ANSWER_S)
            for service in SERVICES
            if service in alive
        )

    def journal(self, service: str) -> bytes:
        """A service's whole journal so far; `parse_journal` reads it."""
        pages: list[bytes] = []
        n_bytes = 0
        while True:
            page = self._bus.ask(JOURNAL[service], JournalPage(offset=n_bytes), timeout_s=ANSWER_S)
            pages.append(page.content)
            n_bytes += len(page.content)
            if not page.content or n_bytes >= page.total:
                return b"".join(pages)

    def _until_left(self, episode: str) -> Iterator[Event]:
        ended = False
        try:
            for event in self.events(episode):
                ended = isinstance(event.happening, Ended)
                yield event
        except PeerMissing:
            ended = True
            raise
        finally:
            if not ended:
                self._try_to_cancel(episode)

    def _try_to_cancel(self, episode: str) -> None:
        try:
            self.cancel(episode)
        except SurefetchError as error:
            log.warning("%s could not be cancelled: %s", episode, error)

    def _next(self) -> Event:
        """The next event of any episode."""
        while True:
            was_alive = PLANNER in self._bus.alive()
            try:
                return self._heard.get(timeout=_LOOK_ROUND_S)
            except queue.Empty:
                if not was_alive:
                    raise PeerMissing(
                        PLANNER, "planner died in the middle of an episode."
                    ) from None
