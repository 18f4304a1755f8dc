"""What every service answers: who it is, what it does, what it recorded."""

from surefetch.common.messages.base import Message, Name, Text


class Status(Message, frozen=True):
    """A service as `surefetch status` shows it."""

    service: Name
    boot: Name
    pid: int
    host: Name
    version: Name
    backend: Name
    """Which implementation runs: `pybullet`, `classical`, …"""
    doing: Text
    n_served: int
    endpoints: tuple[str, ...] = ()
    """Where this service listens and whom it connects to: one endpoint of a cell leads to all."""


class JournalPage(Message, frozen=True):
    """Ask for a service's journal from a byte offset on."""

    offset: int


class JournalBytes(Message, frozen=True):
    """A piece of the journal; empty at its end."""

    offset: int
    content: bytes
    total: int


class Stop(Message, frozen=True):
    """End all motion now. Latches until the process is restarted or a new scene is loaded."""

    who: Text


class Stopped(Message, frozen=True):
    """Motion has ended."""

    was_moving: bool
    took_s: float


class RefusedReply(Message, frozen=True):
    """The error half of every answer: a stable reason and a sentence for people."""

    reason: Name
    text: Text
    exit_code: int = 3
    service: Name | None = None
    """The service that is missing, where that is why."""
