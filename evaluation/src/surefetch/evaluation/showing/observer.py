"""An observer on the bus: it hears events, observations and motions, and fetches the frames.

It asks for nothing else and decides nothing; an episode runs the same without it.
"""

import queue
import threading
import time
from collections.abc import Callable
from typing import Final

from surefetch.common.bus import Bus
from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Captured, Event, Frame, FrameId
from surefetch.common.topics import EVENTS, FRAME, MOVED, OBSERVED
from surefetch.evaluation.showing.observed import Observed, Seen
from surefetch.evaluation.showing.observed_journal import ObservedJournal

FRAME_TIMEOUT_S: Final = 5.0


class Observer:
    """Collects what happens in a cell from now on. Frames are fetched in a thread of its own."""

    def __init__(self, bus: Bus, on_message: Callable[[Seen], None] | None = None) -> None:
        self._bus = bus
        self._on_message = on_message
        self._lock = threading.Lock()
        self._wanted: queue.Queue[FrameId | None] = queue.Queue()
        self.begin()
        bus.listen(EVENTS, self._hear_event)
        bus.listen(OBSERVED, self._hear)
        bus.listen(MOVED, self._hear)
        self._fetcher = threading.Thread(target=self._fetch, name="frames", daemon=True)
        self._fetcher.start()

    def begin(self, journal: ObservedJournal | None = None) -> None:
        """Forget what was seen; a new episode begins, to be kept in this journal too."""
        with self._lock:
            self._journal = journal
            self._log: list[Seen] = []
            self._frames: dict[FrameId, Frame] = {}
            self._lost: list[str] = []

    def close(self, wait_s: float = FRAME_TIMEOUT_S) -> None:
        """Fetch what is still wanted, for so long at most, and end."""
        self._wanted.put(None)
        self._fetcher.join(wait_s)

    def settle(self, wait_s: float = FRAME_TIMEOUT_S) -> None:
        """Wait until all frames that were announced are here, for so long at most."""
        until_s = time.monotonic() + wait_s
        while self._wanted.unfinished_tasks and time.monotonic() < until_s:
            time.sleep(0.01)

    def observed(self) -> Observed:
        """What was seen so far."""
        with self._lock:
            return Observed(tuple(self._log), dict(self._frames))

    def lost(self) -> tuple[str, ...]:
        """What could not be had, in words."""
        with self._lock:
            return tuple(self._lost)

    def _hear_event(self, event: Event) -> None:
        if isinstance(event.happening, Captured):
            self._wanted.put(event.happening.frame)
        self._hear(event)

    def _hear(self, message: Seen) -> None:
        with self._lock:
            self._log.append(message)
            if self._journal is not None:
                self._journal.heard(message)
        if self._on_message is not None:
            self._on_message(message)

    def _fetch(self) -> None:
        while (wanted := self._wanted.get()) is not None:
            try:
                frame = self._bus.ask(FRAME, wanted, timeout_s=FRAME_TIMEOUT_S)
            except SurefetchError as error:
                with self._lock:
                    self._lost.append(f"frame {wanted.counter}: {error}")
            else:
                with self._lock:
                    self._frames[wanted] = frame
                    if self._journal is not None:
                        self._journal.fetched(frame)
            finally:
                self._wanted.task_done()
        self._wanted.task_done()
