"""Replay and live episodes of one table are found equal, and what differs is named."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pytest
from recorded_table import numbers, record
from replayed_table import NEVER_FAILS, TABLES
from scripted_table import CELL, Table, scripted_cell

from surefetch.common.messages import Ended, Target
from surefetch.common.parameters import PROFILES
from surefetch.evaluation.replaying import audit
from surefetch.evaluation.replaying.audit import Course
from surefetch.evaluation.replaying.contenders import contender
from surefetch.evaluation.replaying.evaluate import world_of
from surefetch.evaluation.replaying.scene import ready
from surefetch.evaluation.replaying.sitting import Sitting


def live(table: Table) -> tuple[Course, Target]:
    """An episode of the four services on a fresh copy of a table."""
    with scripted_cell(replace(table, gone=[], executed=[], frames={})) as cell:
        accepted = cell.instruct(after_grasp="hold")
        events = cell.events()
        ended = events[-1].happening
    assert isinstance(ended, Ended)
    return audit.of_live(events, ended), accepted.target


def replayed(table: Table, target: Target, label: str = "ours") -> Course:
    scene = ready(*record(table, wanted=0 if table.things else None, target=target))
    one = contender(label, "extended", {name: numbers(name) for name in PROFILES})
    sitting = Sitting.begin(one, scene, CELL)
    return audit.of_replay(sitting.play(world_of(scene, NEVER_FAILS), sitting.beliefs()))


@pytest.mark.parametrize("name", TABLES)
def test_the_same_table_goes_the_same_way(name: str) -> None:
    table = TABLES[name]
    course, target = live(table)
    found = audit.compare(replayed(table, target), course)
    assert (found.same_actions, found.same_outcome, found.why) == (True, True, "")
    assert found.same_beliefs
    assert found.n_looks == len(course.stops)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"fails": {"right": ["failed"]}}, "it came to right in replay and to right (failed) live"),
        ({"fails": {"grasp": ["failed"]}}, "(failed) live"),
        ({"slips": 1}, "(failed) live"),
        ({"infeasible": frozenset({"right"})}, "only live: right: reach"),
        ({"things": TABLES["one is clear"].things}, "look 1 was read as"),
    ],
)
def test_the_first_thing_that_differs_is_named(
    changes: Mapping[str, Sequence[str]], said: str
) -> None:
    table = TABLES["it must be looked at"]
    course, target = live(replace(table, **changes))  # type: ignore[arg-type]
    found = audit.compare(replayed(table, target), course)
    assert not found.same_actions
    assert said in found.why


def test_another_policy_is_another_course() -> None:
    table = TABLES["it must be looked at"]
    course, target = live(table)
    found = audit.compare(replayed(table, target, "greedy"), course)
    assert not found.same_actions
    assert "look 1: chosen: grasp" in found.why


def test_beliefs_that_differ_are_named_where_the_actions_are_the_same() -> None:
    course, _ = live(TABLES["one is clear"])
    last = course.stops[-1]
    belief = dict(last.belief)
    belief["unobs"] += 1e-6
    other = replace(course, stops=(*course.stops[:-1], replace(last, belief=belief)))
    found = audit.compare(course, other)
    assert (found.same_actions, found.same_outcome, found.same_beliefs) == (True, True, False)
    assert "believed otherwise, by 1.0e-06" in found.why


def test_where_nothing_could_be_compared_nothing_agrees() -> None:
    course, _ = live(TABLES["one is clear"])
    found = audit.compare(Course((), "aborted", "out_of_recording"), course)
    assert (found.same_actions, found.same_outcome, found.same_beliefs) == (False, False, False)
