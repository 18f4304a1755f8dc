"""The stop: asked for from any thread, obeyed by the motion under way, latched afterwards."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from surefetch.common.errors import DeviceFault

REST_S = 2.0
"""Longest wait for a motion to come to rest"""


class StopLatch:
    """Set by a stop; motion polls it."""

    def __init__(self, rest_s: float = REST_S) -> None:
        self._rest_s = rest_s
        self._asked = threading.Event()
        self._at_rest = threading.Event()
        self._at_rest.set()
        self.who = ""

    def asked(self) -> bool:
        """Whether motion must end, and none may begin."""
        return self._asked.is_set()

    def ask(self, who: str) -> None:
        """Stop from now on; returns at once."""
        self.who = self.who or who
        self._asked.set()

    def ask_and_wait(self, who: str) -> tuple[bool, float]:
        """Stop, and wait for rest; whether it moved, and for how long it went on, in seconds.

        Raises:
            DeviceFault: the motion did not come to rest in time.
        """
        began, moving = time.monotonic(), not self._at_rest.is_set()
        self.ask(who)
        if not self._at_rest.wait(self._rest_s):
            raise DeviceFault(
                f"the arm was told to stop and has not come to rest within {self._rest_s:g} s.\n"
                "  Use the emergency stop. No further motion is begun."
            )
        return moving, time.monotonic() - began

    def release(self) -> None:
        """Motion may begin again."""
        self.who = ""
        self._asked.clear()

    @contextmanager
    def moving(self) -> Iterator[None]:
        """While a motion is under way."""
        self._at_rest.clear()
        try:
            yield
        finally:
            self._at_rest.set()
