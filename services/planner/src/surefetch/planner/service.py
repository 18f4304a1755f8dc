"""A sentence in; an episode, told event by event, out. One episode at a time."""

import logging
import secrets
import threading
from collections.abc import Callable
from typing import Any, Final

import msgspec

from surefetch.common.bus import Bus
from surefetch.common.cell import Cell
from surefetch.common.errors import Refused
from surefetch.common.hosted import IDLE
from surefetch.common.instruction import describe, parse
from surefetch.common.messages import Accepted, Cancel, Empty, Equipped, Instruct, Vocabulary
from surefetch.common.parameters import Parameters, check_origin
from surefetch.common.refusals import BUSY
from surefetch.common.runner import Handle, Later
from surefetch.common.topics import (
    BELIEF,
    CANCEL,
    EXECUTOR,
    INSTRUCT,
    PERCEPTION,
    PLANNER,
    VOCABULARY,
)
from surefetch.planner import episode, profiles
from surefetch.planner.account import Account
from surefetch.planner.crew import Crew
from surefetch.planner.prompt_bus import PromptBus
from surefetch.planner.situation import Errand

log = logging.getLogger(__name__)

NEEDED: Final = frozenset({EXECUTOR, PERCEPTION, BELIEF})
VOCABULARY_S: Final = 8.0
TIDY_S: Final = 0.3
"""An episode is told to be over a moment before the next one may begin."""


class PlannerService:
    """Understands a sentence before anything moves, then runs the episode in the work loop."""

    name = PLANNER
    backend = "expectimax"

    def __init__(self, bus: Bus, cell: Cell, parameters_of: Callable[[str], Parameters]) -> None:
        """`parameters_of` a profile raises BadInput."""
        self._bus = PromptBus(bus, NEEDED)
        self._cell = cell
        self._parameters_of = parameters_of
        self._free = threading.Lock()
        self._cancelled = threading.Event()
        self._episode: str | None = None
        self._crew: Crew | None = None

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        """Both are answered while an episode is under way."""
        return (
            Handle(INSTRUCT, self.instruct, concurrent=True),
            Handle(CANCEL, self.cancel, concurrent=True),
        )

    @property
    def doing(self) -> str:
        """Which episode runs, and what it waits for."""
        crew = self._crew
        return IDLE if crew is None else f"{self._episode}, {crew.doing}"

    def peer_gone(self, service: str) -> None:
        """A service died: an episode under way ends now."""
        self._bus.peer_gone(service)

    def instruct(self, request: Instruct) -> Later[Accepted]:
        """Begin an episode.

        Raises:
            Refused: BUSY, an episode is under way.
            BadInput: the sentence is not understood, profile and policy do not go together, or
                the fitted numbers belong to another cell or perception. Nothing was moved.
            PeerMissing, NoAnswer: perception cannot say what it understands.
        """
        if not self._free.acquire(timeout=TIDY_S):
            raise Refused(BUSY, f"episode {self._episode} is under way; cancel it first")
        try:
            self._bus.begin()
            vocabulary = self._bus.ask(VOCABULARY, Empty(), timeout_s=VOCABULARY_S)
            errand = self._errand(request, vocabulary)
        except BaseException:
            self._free.release()
            raise
        accepted = Accepted(
            episode=secrets.token_hex(16),
            target=errand.target,
            understood=describe(errand.target),
        )
        self._episode = accepted.episode
        self._cancelled.clear()
        return Later(accepted, lambda: self._run(accepted, errand))

    def cancel(self, request: Cancel) -> Empty:
        """End an episode after the motion under way. Raises Refused if it is not the one."""
        if request.episode != self._episode:
            raise Refused("UNKNOWN_EPISODE", f"episode {request.episode} is not under way")
        self._cancelled.set()
        return Empty()

    def _errand(self, request: Instruct, vocabulary: Vocabulary) -> Errand:
        policy = profiles.choose(request.profile, request.policy)
        parameters = self._parameters_of(policy.profile.name)
        check_origin(parameters, cell=self._cell.name, backend=vocabulary.backend)
        target = parse(request.sentence, vocabulary)
        return Errand(target, request.after_grasp, policy, parameters, self._cell)

    def _run(self, accepted: Accepted, errand: Errand) -> None:
        account = Account(self._bus, accepted.episode)
        self._crew = Crew(
            self._bus,
            account,
            new_id=lambda: secrets.token_hex(16),
            cancelled=self._cancelled.is_set,
        )
        account.tell(accepted)
        account.tell(equipped(errand))
        ended = episode.run(self._crew, account, errand)
        log.info("%s: %s, %s", accepted.episode, ended.outcome, ended.because)
        self._crew = self._episode = None
        self._free.release()


def equipped(errand: Errand) -> Equipped:
    """All that an episode decides with, for its journal."""
    return Equipped(
        profile=errand.policy.profile.name,
        policy=errand.policy.name,
        after_grasp=errand.after_grasp,
        parameters=msgspec.json.encode(errand.parameters).decode(),
        cell=msgspec.json.encode(errand.cell).decode(),
    )
