"""An episode once more, from the planner's journal alone: the same answers, the decisions anew.

The episode's own loop runs against a bus that answers from the journal. A question that is not the
recorded one ends the replay there: what follows would answer something else.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar

import msgspec

from surefetch.common import codec, refusals
from surefetch.common.bus import Bus
from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput, InfrastructureError
from surefetch.common.journal import Journal, Record
from surefetch.common.messages import (
    Accepted,
    Command,
    Decided,
    Equipped,
    Event,
    Message,
    RefusedReply,
)
from surefetch.common.parameters import Parameters
from surefetch.common.topics import (
    CAPTURE,
    EVENTS,
    EXECUTE,
    FEASIBLE,
    OBSERVE,
    UPDATE,
    Stream,
    Topic,
)
from surefetch.planner import episode, profiles
from surefetch.planner.account import Account
from surefetch.planner.crew import Crew
from surefetch.planner.situation import Errand

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)

OF_AN_EPISODE: Final = frozenset(
    topic.name for topic in (CAPTURE, OBSERVE, UPDATE, FEASIBLE, EXECUTE)
)


@dataclass(frozen=True)
class Redone:
    """One decision, as it was taken and as it is taken again; None: it is not taken again."""

    episode: str
    step: int
    recorded: Decided
    again: Decided | None

    @property
    def same(self) -> bool:
        """Bit for bit, but for how long the thinking took."""
        return self.again is not None and _untimed(self.recorded) == _untimed(self.again)


class Diverged(InfrastructureError):
    """The episode asks something else than it did."""


def decisions(journal: Journal) -> list[Redone]:
    """Every decision in a planner's journal, taken again.

    Raises:
        BadInput: it is no planner's journal, or one without an episode.
    """
    episodes = list(_episodes(journal))
    if not episodes:
        raise BadInput(
            f"the journal of {journal.header.service} holds no episode; the planner's does"
        )
    return [one for recorded in episodes for one in _redo(recorded)]


@dataclass(frozen=True, eq=False)
class _Episode:
    """The records of one episode."""

    accepted: Accepted
    equipped: Equipped
    events: Sequence[Event]
    records: Sequence[Record]
    """Asked and answered."""


def _episodes(journal: Journal) -> Iterator[_Episode]:
    told: dict[str, list[Event]] = {}
    for record in journal.records:
        if record.kind == "event" and record.topic == EVENTS.name:
            event = record.message(Event)
            told.setdefault(event.episode, []).append(event)
    for name, events in told.items():
        accepted = _first(events, Accepted)
        equipped = _first(events, Equipped)
        if accepted is not None and equipped is not None:
            yield _Episode(accepted, equipped, events, _asked(journal, name))


def _first(events: Sequence[Event], kind: type[R]) -> R | None:
    return next((e.happening for e in events if isinstance(e.happening, kind)), None)


def _asked(journal: Journal, episode_name: str) -> list[Record]:
    """What an episode asked, each question followed by what came back."""
    back = {r.call: r for r in journal.records if r.kind in ("answer", "failure")}
    records: list[Record] = []
    for record in journal.records:
        if record.kind != "ask" or record.topic not in OF_AN_EPISODE:
            continue
        if _episode_of(record) == episode_name:
            records += [record, *([back[record.call]] if record.call in back else [])]
    return records


def _episode_of(record: Record) -> str:
    envelope: dict[str, Any] = msgspec.msgpack.decode(record.body)
    return str(envelope["body"]["episode"])


class _JournalBus:
    """Answers every question with what was answered, if it is the same question."""

    def __init__(self, records: Sequence[Record]) -> None:
        self._records = list(records)
        self.events: list[Event] = []

    @property
    def boot(self) -> str:
        return "journal"

    def ask(self, topic: Topic[Q, R], request: Q, *, timeout_s: float) -> R:  # noqa: ARG002
        encoded = codec.encode(request, max_bytes=topic.max_request_bytes)
        asked = self._next("ask", topic.name)
        if bytes(asked.body) != encoded:
            raise Diverged(f"{topic.name} is asked something else than in the journal.")
        back = self._next(None, topic.name)
        if back.kind == "failure":
            raise refusals.error_of(back.message(RefusedReply))
        return back.message(topic.reply)

    def publish(self, stream: Stream[Q], message: Q) -> None:  # noqa: ARG002
        if isinstance(message, Event):
            self.events.append(message)

    def listen(self, stream: Stream[Q], on_message: Callable[[Q], None]) -> None:
        """Nobody speaks in a journal."""

    def alive(self) -> frozenset[str]:
        return frozenset()

    def _next(self, kind: str | None, topic: str) -> Record:
        if not self._records:
            raise Diverged("the journal ends here.")
        record = self._records.pop(0)
        if record.topic != topic or (kind is not None and record.kind != kind):
            raise Diverged(f"{topic} is asked where the journal has {record.topic}.")
        return record


def _redo(recorded: _Episode) -> list[Redone]:
    errand = errand_of(recorded.accepted, recorded.equipped)
    bus = _JournalBus(recorded.records)
    _rerun(bus, recorded, errand)
    again = {e.step: e.happening for e in bus.events if isinstance(e.happening, Decided)}
    return [
        Redone(recorded.accepted.episode, e.step, e.happening, again.get(e.step))
        for e in recorded.events
        if isinstance(e.happening, Decided)
    ]


def _rerun(bus: Bus, recorded: _Episode, errand: Errand) -> None:
    """The episode's own loop, with the recorded commands' identities."""
    ids = [r.message(Command).cmd_id for r in recorded.records if _is_command(r)]
    remaining = iter(ids)
    account = Account(bus, recorded.accepted.episode)
    crew = Crew(
        bus,
        account,
        new_id=lambda: next(remaining, "none was given"),
        cancelled=lambda: False,
    )
    episode.run(crew, account, errand)


def _is_command(record: Record) -> bool:
    return record.kind == "ask" and record.topic == EXECUTE.name


def errand_of(accepted: Accepted, equipped: Equipped) -> Errand:
    """What an episode was to fetch, and by which rules and numbers.

    Raises:
        BadInput: the journal names a policy or parameters that this version does not know.
    """
    try:
        parameters = msgspec.json.decode(equipped.parameters, type=Parameters)
        cell = msgspec.json.decode(equipped.cell, type=Cell)
    except msgspec.MsgspecError as error:
        raise BadInput(f"the journal is of another version: {error}") from None
    policy = profiles.choose(equipped.profile, equipped.policy)
    return Errand(accepted.target, equipped.after_grasp, policy, parameters, cell)


def _untimed(decided: Decided) -> Decided:
    return msgspec.structs.replace(decided, duration_s=0.0)
