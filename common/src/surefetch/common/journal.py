"""What a service was asked and answered, and what it asked itself, in a file that grows at its end.

A record is its length in four bytes, little-endian, then MessagePack. The first is a `Header` with
the format's version, all others are a `Record`. Every record is with the operating system before
the next thing happens, so a killed process loses at most the one it was writing.
"""

import struct
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, TypeVar

import msgspec

from surefetch.common import codec
from surefetch.common.errors import BadInput
from surefetch.common.messages.base import Message

FORMAT: Final = 1
MAX_RECORD_BYTES: Final = 80 * 1024 * 1024
LENGTH: Final = struct.Struct("<I")

Kind = Literal["request", "reply", "refusal", "ask", "answer", "failure", "event"]
"""Served here: request, then reply or refusal. Asked elsewhere: ask, then answer or failure, which
is a `RefusedReply` too. Published: event."""

M = TypeVar("M", bound=Message)


class Header(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The first record."""

    format: int
    service: str
    boot: str
    started_s: float
    """Seconds since 1970, of the service's host."""


class Record(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One message that went in or out."""

    seq: int
    """From 0, without gaps."""
    kind: Kind
    topic: str
    """``service/verb``"""
    call: int
    """The same number in a question and its answer."""
    time_s: float
    """Monotonic, from the header on."""
    body: msgspec.Raw
    """The message with its envelope, as it travels."""

    def message(self, expected: type[M]) -> M:
        """The message. Raises CodecError."""
        return codec.decode(bytes(self.body), expected, max_bytes=MAX_RECORD_BYTES)


@dataclass(frozen=True)
class Journal:
    """A journal as read."""

    header: Header
    records: tuple[Record, ...]
    torn_bytes: int
    """Bytes at the end that are no whole record: the process died while it wrote."""


class JournalWriter:
    """Appends records; several threads may write."""

    def __init__(self, path: Path, service: str, boot: str) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path = path
        self._file = path.open("xb", buffering=0)
        self._lock = threading.Lock()
        self._seq = 0
        self._calls = 0
        self._start_s = time.monotonic()
        self._append(Header(FORMAT, service, boot, time.time()))

    def new_call(self) -> int:
        """A number for one question and its answer."""
        with self._lock:
            self._calls += 1
            return self._calls

    def write(self, kind: Kind, topic: str, call: int, encoded: bytes) -> None:
        """Append one record; `encoded` as `codec.encode` gives it."""
        with self._lock:
            time_s = time.monotonic() - self._start_s
            self._append(Record(self._seq, kind, topic, call, time_s, msgspec.Raw(encoded)))
            self._seq += 1

    def page(self, offset: int, max_bytes: int) -> tuple[bytes, int]:
        """A piece of the file from an offset on, and the file's size."""
        total = self.path.stat().st_size
        with self.path.open("rb") as file:
            file.seek(min(max(0, offset), total))
            return file.read(max_bytes), total

    def close(self) -> None:
        """No record after this."""
        with self._lock:
            self._file.close()

    def _append(self, record: Header | Record) -> None:
        body = msgspec.msgpack.encode(record)
        self._file.write(LENGTH.pack(len(body)) + body)


def parse_journal(content: bytes, origin: str) -> Journal:
    """The records in a journal's bytes; `origin` names it in errors.

    Raises:
        BadInput: no journal, or of another format.
    """
    bodies, torn_bytes = _split(content)
    try:
        header = msgspec.msgpack.decode(bodies[0], type=Header)
        if header.format != FORMAT:
            raise BadInput(f"journal {origin} has format {header.format}; this reads {FORMAT}")
        records = tuple(msgspec.msgpack.decode(body, type=Record) for body in bodies[1:])
    except IndexError:
        raise BadInput(f"journal {origin} is empty") from None
    except msgspec.MsgspecError as error:
        raise BadInput(f"{origin} is no journal, or a damaged one: {error}") from None
    return Journal(header, records, torn_bytes)


def read_journal(path: Path) -> Journal:
    """Read a journal file. Raises BadInput."""
    try:
        return parse_journal(path.read_bytes(), str(path))
    except OSError as error:
        raise BadInput(f"journal {path} cannot be read: {error.strerror}") from None


def _split(content: bytes) -> tuple[list[bytes], int]:
    """The bodies of all whole records, and how many bytes are left over."""
    bodies, start = [], 0
    while start + LENGTH.size <= len(content):
        (length,) = LENGTH.unpack_from(content, start)
        end = start + LENGTH.size + length
        if end > len(content):
            break
        bodies.append(content[start + LENGTH.size : end])
        start = end
    return bodies, len(content) - start
