"""One live episode from outside: instruct, follow, and end it in good order in any case."""

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Final

from surefetch.common.bus import Bus
from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Accepted, Cancel, Ended, Event, Instruct, Stop
from surefetch.common.topics import CANCEL, EXECUTOR, INSTRUCT, PLANNER, STOP
from surefetch.evaluation.running.ending import aborted, stopped
from surefetch.evaluation.showing.observed import Observed, Seen
from surefetch.evaluation.showing.observer import Observer

INSTRUCT_S: Final = 15.0
STOP_S: Final = 3.0
LAST_WORD_S: Final = 0.6
"""How long the planner may take to say how an episode ended that cannot go on."""
SILENCE_S: Final = 180.0
"""Between two events of an episode; a motion is one event, and is bounded."""
POLL_S: Final = 0.05
GONE_S: Final = 0.3
"""How long to wait for the token of a service that the planner misses."""


class Follower:
    """Begins episodes on a bus and follows them to their end."""

    def __init__(
        self,
        bus: Bus,
        observer: Observer,
        *,
        how_it_died: Callable[[str], str],
        silence_s: float,
    ) -> None:
        """Follow episodes; `on_event` and `on_gone` are to be called from the bus's threads."""
        self._bus = bus
        self._observer = observer
        self._how_it_died = how_it_died
        self._silence_s = silence_s
        self._events: SimpleQueue[Event] = SimpleQueue()
        self._gone: SimpleQueue[str] = SimpleQueue()

    def on_message(self, message: Seen) -> None:
        """Hear what the observer hears."""
        if isinstance(message, Event):
            self._events.put(message)

    def on_gone(self, service: str) -> None:
        """Hear that a service's token went."""
        self._gone.put(service)

    def instruct(self, instruct: Instruct) -> Accepted:
        """Begin an episode. Raises what `Bus.ask` raises; the planner's own no is a `Refused`."""
        return self._bus.ask(INSTRUCT, instruct, timeout_s=INSTRUCT_S)

    def follow(
        self, accepted: Accepted, show: Callable[[Event], None], interrupted: threading.Event
    ) -> Ended:
        """Show the episode's events until it has ended; its end, which is not shown, in any case.

        A service that dies, a planner that falls silent and an interrupt end it too: then all
        motion is stopped first.
        """
        heard_s = time.monotonic()
        while True:
            event = self._next_event(accepted.episode)
            if event is not None:
                heard_s = time.monotonic()
                if isinstance(event.happening, Ended):
                    return self._as_told(event.happening)
                show(event)
            elif interrupted.is_set():
                return self._stop(accepted, show)
            elif not self._gone.empty():
                return self._abort(accepted, self._gone.get(), show)
            elif time.monotonic() - heard_s > self._silence_s:
                return self._give_up()

    def _next_event(self, episode: str, timeout_s: float = POLL_S) -> Event | None:
        try:
            event = self._events.get(timeout=timeout_s)
        except Empty:
            return None
        return event if event.episode == episode else None

    def _as_told(self, told: Ended) -> Ended:
        """The planner's account; that of an abort is completed by what this side knows."""
        if told.outcome != "aborted":
            return told
        try:
            return self._lost(self._gone.get(timeout=GONE_S), told)
        except Empty:
            at_rest = self._halt("the episode was aborted")
            return aborted(told.reason, f"{told.because} {at_rest}", self._seen(), told)

    def _abort(self, accepted: Accepted, service: str, show: Callable[[Event], None]) -> Ended:
        """End an episode that lost a service; a good end that was under way still counts."""
        at_rest = self._halt(f"{service} died")
        told = self._last_word(accepted, show)
        if told is not None and told.outcome not in ("aborted", "stopped"):
            return told
        return self._lost(service, told, at_rest)

    def _lost(self, service: str, told: Ended | None, at_rest: str = "") -> Ended:
        at_rest = at_rest or self._halt(f"{service} died")
        how = self._how_it_died(service)
        sentence = f"{service} died in mid-episode{f' ({how})' if how else ''}. {at_rest}"
        return aborted(f"{service}_died", sentence, self._seen(), told)

    def _stop(self, accepted: Accepted, show: Callable[[Event], None]) -> Ended:
        at_rest = self._halt("the operator interrupted the run")
        with suppress(SurefetchError):  # it has ended, or its planner is gone: the last word tells
            self._bus.ask(CANCEL, Cancel(episode=accepted.episode), timeout_s=STOP_S)
        told = self._last_word(accepted, show, STOP_S)
        return stopped(f"Stopped by the operator. {at_rest}", self._seen(), told)

    def _give_up(self) -> Ended:
        at_rest = self._halt("the planner fell silent")
        sentence = f"{PLANNER} has said nothing for {self._silence_s:.0f} s. {at_rest}"
        return aborted("planner_silent", sentence, self._seen(), None)

    def _halt(self, why: str) -> str:
        """Stop all motion; a sentence on what came of it."""
        if EXECUTOR not in self._bus.alive():
            return "The executor is gone, and with it what moved the arm."
        try:
            self._bus.ask(STOP, Stop(who=f"surefetch run: {why}"), timeout_s=STOP_S)
        except SurefetchError as error:
            return f"Whether the arm is at rest is not known: {error}"
        return "The arm is at rest."

    def _last_word(
        self, accepted: Accepted, show: Callable[[Event], None], timeout_s: float = LAST_WORD_S
    ) -> Ended | None:
        until_s = time.monotonic() + timeout_s
        while PLANNER in self._bus.alive() and time.monotonic() < until_s:
            event = self._next_event(accepted.episode)
            if event is None:
                continue
            if isinstance(event.happening, Ended):
                return event.happening
            show(event)
        return None

    def _seen(self) -> Observed:
        return self._observer.observed()
