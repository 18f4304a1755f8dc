"""Episodes taken again from their journals come out the same; altered journals do not."""

from collections.abc import Callable
from dataclasses import replace as with_
from typing import TypeVar

import msgspec
import pytest
from msgspec.structs import replace
from scripted_table import Table, scripted_cell, thing, thing_inside

from surefetch.common import codec
from surefetch.common.errors import BadInput
from surefetch.common.journal import Journal, Record
from surefetch.common.messages import BeliefReply, Decided, Event, Feasibility, Message
from surefetch.planner.replay import Redone, decisions

M = TypeVar("M", bound=Message)

UNSURE = [thing(0.8, 0.2, "unread", right="match"), thing(0.8, -0.2, "other")]
TABLES: dict[str, Callable[[], Table]] = {
    "grasped": lambda: Table(UNSURE),
    "covered": lambda: Table([thing_inside(), thing(0.7, 0.2, "other")], covered=True),
    "twins": lambda: Table([thing(0.8, 0.2), thing(0.8, -0.2)]),
    "empty": lambda: Table([], covered=None),
    "failing": lambda: Table(UNSURE, fails={"right": ["failed"], "grasp": ["failed"]}),
    "stopped": lambda: Table(UNSURE, fails={"right": ["stopped"]}),
}


def recorded(table: Table, profile: str = "extended") -> tuple[Journal, Journal]:
    """The planner's journal of one episode, and the belief's."""
    with scripted_cell(table) as cell:
        cell.fetch(profile=profile)
        return cell.journal("planner"), cell.journal("belief")


@pytest.mark.parametrize("profile", ["extended", "paper"])
@pytest.mark.parametrize("name", sorted(TABLES))
def test_decisions_come_out_the_same_bit_for_bit(name: str, profile: str) -> None:
    journal, _ = recorded(TABLES[name](), profile)
    redone = decisions(journal)
    taken = [r for r in journal.records if r.kind == "event" and _decided(r) is not None]
    assert len(redone) == len(taken) > 0
    assert all(one.same for one in redone)


def test_several_episodes_of_one_journal_are_told_apart() -> None:
    table = Table([thing(0.8, 0.2), thing(0.8, -0.2)])
    with scripted_cell(table) as cell:
        cell.fetch()
        cell.fetch(profile="paper")
        redone = decisions(cell.journal("planner"))
    assert len({one.episode for one in redone}) == 2
    assert all(one.same for one in redone)


def test_a_journal_cut_short_is_replayed_as_far_as_it_goes() -> None:
    journal, _ = recorded(TABLES["covered"]())
    for n in range(len(journal.records)):
        cut = with_(journal, records=journal.records[:n])
        if any(_decided(r) is not None for r in cut.records):
            assert all(one.same for one in decisions(cut))


def test_another_belief_does_not_give_the_recorded_decision() -> None:
    journal, _ = recorded(TABLES["grasped"]())

    def sure(reply: BeliefReply) -> BeliefReply:
        told = dict.fromkeys(reply.belief, 0.0) | {"abs": 1.0}
        return replace(reply, belief=told, gamma=("abs",))

    first, *others = decisions(altered(journal, "belief/update", BeliefReply, sure))
    assert not first.same
    assert first.again is not None
    assert [one.again for one in others] == [None] * len(others)


def test_another_verdict_of_the_robot_shows_in_the_decision() -> None:
    journal, _ = recorded(TABLES["grasped"]())

    def never(answer: Feasibility) -> Feasibility:
        return replace(answer, grasps=tuple(replace(g, feasible=False) for g in answer.grasps))

    redone = decisions(altered(journal, "executor/feasible", Feasibility, never))
    assert not all(one.same for one in redone)


def test_an_altered_decision_is_found() -> None:
    journal, _ = recorded(TABLES["twins"]())

    def cheaper(event: Event) -> Event:
        if not isinstance(event.happening, Decided):
            return event
        q_values = tuple(replace(q, value=q.value - 1e-15) for q in event.happening.q_values)
        return replace(event, happening=replace(event.happening, q_values=q_values))

    redone = decisions(altered(journal, "planner/event", Event, cheaper, kind="event"))
    assert not any(one.same for one in redone)


def test_only_the_time_to_think_may_differ() -> None:
    journal, _ = recorded(TABLES["twins"]())
    one = decisions(journal)[0]
    slower = replace(one.recorded, duration_s=one.recorded.duration_s + 5.0)
    assert with_(one, recorded=slower).same
    assert not Redone(one.episode, one.step, replace(slower, because="no"), one.again).same


def test_a_journal_without_an_episode_is_bad_input() -> None:
    planner, belief = recorded(TABLES["twins"]())
    with pytest.raises(BadInput, match="belief holds no episode"):
        decisions(belief)
    with pytest.raises(BadInput, match="no episode"):
        decisions(with_(planner, records=()))


def _decided(record: Record) -> Decided | None:
    if record.topic != "planner/event":
        return None
    happening = record.message(Event).happening
    return happening if isinstance(happening, Decided) else None


def altered(
    journal: Journal, topic: str, kind_of: type[M], change: Callable[[M], M], kind: str = "answer"
) -> Journal:
    """The journal with every message of one kind changed."""

    def changed(record: Record) -> Record:
        if (record.topic, record.kind) != (topic, kind):
            return record
        message = change(record.message(kind_of))
        encoded = codec.encode(message, max_bytes=1 << 24)
        return replace(record, body=msgspec.Raw(encoded))

    return with_(journal, records=tuple(changed(r) for r in journal.records))
