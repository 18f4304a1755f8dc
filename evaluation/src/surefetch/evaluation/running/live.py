"""Episodes in a live cell, one after another: table set, instructed, followed, and collected."""

import secrets
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final

from surefetch.common.errors import Refused, SurefetchError
from surefetch.common.hosted import IDLE
from surefetch.common.messages import (
    Accepted,
    AskTruth,
    Empty,
    Ended,
    Event,
    Instruct,
    Scene,
    Truth,
)
from surefetch.common.refusals import BUSY
from surefetch.common.topics import LOAD_SCENE, PLANNER, STATUS, TRUTH
from surefetch.evaluation.running import journals as run_journals
from surefetch.evaluation.running.cell import LiveCell
from surefetch.evaluation.running.episode import SILENCE_S, Follower
from surefetch.evaluation.showing.observed import Observed
from surefetch.evaluation.showing.observed_journal import OBSERVER, ObservedJournal
from surefetch.evaluation.showing.observer import Observer

LOAD_S: Final = 60.0
TRUTH_S: Final = 5.0
STATUS_S: Final = 5.0
TIDY_S: Final = 2.0
"""A planner that has told the end of an episode is idle within this."""
FRAMES_S: Final = 1.5
"""How long to wait for the last frames, once the episode is over."""


@dataclass(frozen=True, eq=False)
class Finished:
    """An episode that is over, with all that could be had of it."""

    accepted: Accepted
    ended: Ended
    observed: Observed
    truth: Truth | None
    """Of a simulated cell; None on others, and when it could not be had."""
    journals: Mapping[str, bytes]
    missing: tuple[str, ...]
    wall_s: float


class Live:
    """This process in a cell, as operator and scorer."""

    def __init__(self, cell: LiveCell, *, silence_s: float = SILENCE_S) -> None:
        """Join; `silence_s` is how long a planner may say nothing in mid-episode."""
        self.cell = cell
        self._observer = Observer(cell.bus, lambda message: self._follower.on_message(message))
        self._follower = Follower(
            cell.bus, self._observer, how_it_died=cell.how_it_died, silence_s=silence_s
        )
        cell.bus.on_gone(self._follower.on_gone)

    def run(
        self, instruct: Instruct, scene: Scene | None, show: Callable[[Event], None]
    ) -> Finished:
        """One episode, on this scene or on what stands on the table.

        Raises:
            BadInput, Refused: the instruction cannot be used; nothing moved.
            InfrastructureError: a service died before the episode began.
        """
        bus, began_s = self.cell.bus, time.monotonic()
        sizes = run_journals.sizes(bus)
        if scene is not None:
            self._refuse_if_busy()
            bus.ask(LOAD_SCENE, scene, timeout_s=LOAD_S)
        kept = self.cell.folder / f"{OBSERVER}-{secrets.token_hex(4)}.journal"
        journal = ObservedJournal(kept, bus.boot)
        self._observer.begin(journal)
        with interruptible() as interrupted:
            accepted = self._follower.instruct(instruct)
            ended = self._follower.follow(accepted, show, interrupted)
        self._observer.settle(FRAMES_S)
        journals, missing = run_journals.collect(bus, sizes, self.cell.folder)
        truth, unknown = (None, ()) if scene is None else self._truth()
        observed, lost = self._observer.observed(), self._observer.lost()
        self._observer.begin(None)
        journal.close()
        return Finished(
            accepted=accepted,
            ended=ended,
            observed=observed,
            truth=truth,
            journals={**journals, OBSERVER: kept.read_bytes()},
            missing=(*lost, *missing, *unknown),
            wall_s=time.monotonic() - began_s,
        )

    def _refuse_if_busy(self) -> None:
        """Leave the table as it is while somebody else's episode is under way on it."""
        until_s = time.monotonic() + TIDY_S
        while (doing := self._planner_does()) != IDLE:
            if time.monotonic() < until_s:
                time.sleep(0.05)
                continue
            raise Refused(
                BUSY,
                f"an episode is under way in this cell ({doing}).\n"
                "  Wait for its end, or end it: surefetch stop. Nothing was changed.",
            )

    def _planner_does(self) -> str:
        return self.cell.bus.ask(STATUS[PLANNER], Empty(), timeout_s=STATUS_S).doing

    def _truth(self) -> tuple[Truth | None, tuple[str, ...]]:
        try:
            return self.cell.bus.ask(TRUTH, AskTruth(), timeout_s=TRUTH_S), ()
        except SurefetchError as error:
            return None, (f"the truth: {error}",)


@contextmanager
def interruptible() -> Iterator[threading.Event]:
    """Set on the first Ctrl-C or SIGTERM in the block; the second Ctrl-C is raised as usual."""
    interrupted = threading.Event()

    def on_signal(*_: object) -> None:
        interrupted.set()
        signal.signal(signal.SIGINT, signal.default_int_handler)

    earlier = {n: signal.signal(n, on_signal) for n in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield interrupted
    finally:
        for number, handler in earlier.items():
            signal.signal(number, handler)
