"""A running cell as Rerun recordings, one per episode, written while it happens."""

from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Final

import rerun as rr

from surefetch.common.bus import Bus
from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Captured, Event, Frame, FrameId
from surefetch.common.topics import EVENTS, FRAME, MOVED, OBSERVED
from surefetch.evaluation.showing.observed import Seen
from surefetch.evaluation.showing.recording_view import EpisodeView

FRAME_TIMEOUT_S: Final = 5.0
POLL_S: Final = 0.3

Begin = Callable[[str], rr.RecordingStream]
"""Opens the recording of an episode, by its id."""


class LiveView:
    """Hears a cell and draws it, in order; it asks for frames and for nothing else."""

    def __init__(self, bus: Bus, begin: Begin, on_event: Callable[[Event], None]) -> None:
        self._bus = bus
        self._begin = begin
        self._on_event = on_event
        self._heard: SimpleQueue[Seen] = SimpleQueue()
        self._episode = ""
        self._recording: rr.RecordingStream | None = None
        self._view: EpisodeView | None = None
        bus.listen(EVENTS, self._heard.put)
        bus.listen(OBSERVED, self._heard.put)
        bus.listen(MOVED, self._heard.put)

    def draw_until(self, over: Callable[[], bool]) -> None:
        """Draw what comes until this is so and nothing more is waiting."""
        while True:
            try:
                self._draw(self._heard.get(timeout=POLL_S))
            except Empty:
                if over():
                    return

    def close(self) -> None:
        """Write out what is pending."""
        if self._recording is not None:
            self._recording.flush()
            self._recording.disconnect()

    def _draw(self, message: Seen) -> None:
        view = self._view_for(message)
        frames: dict[FrameId, Frame] = {}
        if isinstance(message, Event):
            if isinstance(message.happening, Captured):
                frames = self._fetch(message.happening.frame)
            self._on_event(message)
        view.add(message, frames)

    def _view_for(self, message: Seen) -> EpisodeView:
        """The view of the message's episode; whoever joins late begins in the midst of one."""
        episode = message.episode if isinstance(message, Event) else self._episode
        if self._view is None or (episode != self._episode and self._episode):
            self.close()
            self._recording = self._begin(episode or "joined")
            self._view = EpisodeView(self._recording)
        self._episode = episode
        return self._view

    def _fetch(self, wanted: FrameId) -> dict[FrameId, Frame]:
        try:
            return {wanted: self._bus.ask(FRAME, wanted, timeout_s=FRAME_TIMEOUT_S)}
        except SurefetchError:
            return {}
