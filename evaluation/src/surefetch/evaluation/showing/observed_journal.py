"""What an observer saw, in a journal: enough to draw every picture of the run again."""

from pathlib import Path
from typing import Any, Final

from surefetch.common import codec
from surefetch.common.errors import BadInput, CodecError
from surefetch.common.journal import JournalWriter, read_journal
from surefetch.common.messages import Event, Frame, FrameId, Message, Motion, Observations
from surefetch.common.topics import EVENTS, FRAME, MOVED, OBSERVED, Stream
from surefetch.evaluation.showing.observed import Observed, Seen

OBSERVER: Final = "observer"
STREAMS: Final[dict[str, Stream[Any]]] = {s.name: s for s in (EVENTS, OBSERVED, MOVED)}
STREAM_OF: Final[dict[type[Message], Stream[Any]]] = {
    Event: EVENTS,
    Observations: OBSERVED,
    Motion: MOVED,
}


class ObservedJournal:
    """Keeps what comes, as it comes; a run that is cut short has kept what it saw."""

    def __init__(self, path: Path, boot: str) -> None:
        self._writer = JournalWriter(path, OBSERVER, boot)

    def heard(self, message: Seen) -> None:
        """A message of a stream."""
        stream = STREAM_OF[type(message)]
        encoded = codec.encode(message, max_bytes=stream.max_bytes)
        self._writer.write("event", stream.name, 0, encoded)

    def fetched(self, frame: Frame) -> None:
        """A frame, as the executor sent it."""
        encoded = codec.encode(frame, max_bytes=FRAME.max_reply_bytes)
        self._writer.write("answer", FRAME.name, self._writer.new_call(), encoded)

    def close(self) -> None:
        """No more comes."""
        self._writer.close()


def read_observed(path: Path) -> Observed:
    """What such a journal holds. Raises BadInput when it is no journal, or a damaged one."""
    journal = read_journal(path)
    log: list[Seen] = []
    frames: dict[FrameId, Frame] = {}
    try:
        for record in journal.records:
            if record.topic == FRAME.name:
                frame = record.message(Frame)
                frames[frame.info.frame] = frame
            elif record.topic in STREAMS:
                log.append(record.message(STREAMS[record.topic].message))
    except CodecError as error:
        raise BadInput(f"journal {path} cannot be read by this version: {error}") from None
    return Observed(tuple(log), frames)
