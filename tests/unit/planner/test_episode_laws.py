"""What no episode ever does, whatever stands on the table and whatever goes wrong."""

from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scripted_table import CELL, VIEWS, Reading, ScriptedCell, Table, Thing, scripted_cell

from surefetch.common.hypotheses import ABS, parse_tracked
from surefetch.common.messages import (
    Acting,
    Command,
    Decided,
    Defer,
    Ended,
    Event,
    Grasp,
    Inform,
)
from surefetch.planner.profiles import PROFILES
from surefetch.planner.replay import decisions

PLACES = ((0.7, 0.25), (0.7, -0.25), (0.95, 0.3), (0.95, -0.3), (1.2, 0.25))
INFORMS = tuple(row.name for row in (*CELL.informs, *CELL.covered_views))
readings: st.SearchStrategy[Reading] = st.sampled_from(("match", "other", "unread", "hidden"))
statuses = st.sampled_from(("done", "failed", "refused"))
sentences = st.sampled_from(
    ("the red object", "the red object inside the box", "the red object outside the box")
)


@st.composite
def things(draw: st.DrawFn) -> list[Thing]:
    outside = [
        Thing(place, {view: draw(readings) for view in VIEWS})
        for place in draw(st.lists(st.sampled_from(PLACES), unique=True, max_size=3))
    ]
    inside = [
        Thing((1.0, y), {view: draw(readings) for view in VIEWS}, inside=True)
        for y in draw(st.sampled_from([(), (0.0,), (-0.08, 0.08)]))
    ]
    return [*outside, *inside]


@st.composite
def tables(draw: st.DrawFn) -> Table:
    scripts = st.lists(statuses, max_size=4)
    names = (*INFORMS, "grasp", "look", "deliver")
    return Table(
        things=draw(things()),
        covered=draw(st.sampled_from([True, False, None])),
        fails=draw(st.dictionaries(st.sampled_from(names), scripts, max_size=3)),
        stuck_lid=draw(st.booleans()),
        infeasible=draw(st.frozensets(st.sampled_from((*INFORMS, "grasp")), max_size=2)),
        slips=draw(st.integers(0, 2)),
    )


def episode(cell: ScriptedCell, sentence: str, profile: str) -> tuple[list[Event], Ended]:
    cell.instruct(sentence, profile)
    events = cell.events()
    ended = events[-1].happening
    assert isinstance(ended, Ended)
    return events, ended


def grasps_with_decisions(events: Sequence[Event]) -> list[tuple[Grasp, Decided]]:
    latest: Decided | None = None
    found = []
    for happening in (e.happening for e in events):
        if isinstance(happening, Decided):
            latest = happening
        if isinstance(happening, Acting) and isinstance(happening.verb, Grasp):
            assert latest is not None
            found.append((happening.verb, latest))
    return found


@settings(deadline=None, max_examples=60)
@given(tables(), sentences, st.sampled_from(sorted(PROFILES)))
def test_whatever_happens_the_rules_are_kept(table: Table, sentence: str, profile: str) -> None:
    with scripted_cell(table, q_hat=0.8) as cell:
        events, ended = episode(cell, sentence, profile)
        redone = decisions(cell.journal("planner"))
    assert sum(isinstance(e.happening, Ended) for e in events) == 1
    assert ended.outcome in {"grasped", "deferred", "failed", "stalled"}
    assert all(one.same for one in redone) and len(redone) == len(_decided(events))
    _check_grasps(events, ended, sentence)
    _check_bounds(table, profile)
    _check_defer(table, events, ended, profile)
    if profile == "paper":
        _check_paper(table, ended)
    for step in ended.steps:
        assert sum(step.belief.values()) == pytest.approx(1.0, abs=1e-9)
        if step.q_values:
            assert min(q.value for q in step.q_values) >= 0.0


def _decided(events: Sequence[Event]) -> list[Decided]:
    return [e.happening for e in events if isinstance(e.happening, Decided)]


def _check_grasps(events: Sequence[Event], ended: Ended, sentence: str) -> None:
    """Never a grasp but of the one hypothesis left that is allowed and that the robot can do."""
    asked = next((r for r in ("inside", "outside") if r in sentence), "any")
    gammas = {e.step: s.gamma for e, s in zip(_of_steps(events), ended.steps, strict=True)}
    for event in events:
        verb = event.happening.verb if isinstance(event.happening, Acting) else None
        if isinstance(verb, Grasp):
            parsed = [p for z in gammas[event.step] if (p := parse_tracked(z)) is not None]
            allowed = [p for p in parsed if asked in ("any", p[1])]
            assert allowed == [(verb.track, verb.relation)]
    for grasp, decided in grasps_with_decisions(events):
        (verdict,) = [v for v in decided.feasibility.grasps if v.track == grasp.track]
        assert verdict.feasible
        assert decided.choice == grasp


def _of_steps(events: Sequence[Event]) -> list[Event]:
    return [e for e in events if type(e.happening).__name__ == "Believed"]


def _check_bounds(table: Table, profile: str) -> None:
    rules = PROFILES[profile]
    taken = [c.verb for c in table.executed if isinstance(c.verb, Inform | Grasp)]
    assert len(taken) <= rules.max_actions
    for name in INFORMS:
        assert taken.count(Inform(name=name)) <= rules.tries
    ids = [c.cmd_id for c in table.executed]
    assert len(set(ids)) == len(ids)


def _check_defer(table: Table, events: Sequence[Event], ended: Ended, profile: str) -> None:
    """A defer is a decision, and never because something failed."""
    if ended.outcome != "deferred":
        return
    last = _decided(events)[-1]
    assert isinstance(last.choice, Defer)
    step, rules = ended.steps[-1], PROFILES[profile]
    if step.gamma == (ABS,) and step.belief[ABS] >= rules.defer_at_least:
        return
    cover = "covered" if table.covered else "open"
    for row in rules.rows(CELL):
        if row.requires == cover and row.name not in table.infeasible:
            assert _succeeded(table, row.name), f"{row.name} was never seen through"


def _succeeded(table: Table, name: str) -> bool:
    tries = [c for c in table.executed if c.verb == Inform(name=name)]
    script = table.fails.get(name, ())
    return any(n >= len(script) or script[n] == "done" for n in range(len(tries)))


def _check_paper(table: Table, ended: Ended) -> None:
    """The first failed interaction is the last."""
    failed = [
        a for a in ended.actions if a.status != "done" and a.action not in ("deliver", "look")
    ]
    assert len(failed) <= 1
    if failed:
        assert ended.outcome == "failed"


@settings(deadline=None, max_examples=25)
@given(tables(), st.integers(0, 6), st.sampled_from(["perception", "belief", "executor"]))
def test_nothing_is_begun_after_a_death_and_it_never_ends_in_a_defer(
    table: Table, nth: int, victim: str
) -> None:
    def kill(_: Command) -> None:
        if len(table.executed) == nth + 1:
            cell.kill(victim)

    table.on_execute = kill
    with scripted_cell(table) as cell:
        _, ended = episode(cell, "the red object", "extended")
    if len(table.executed) <= nth:
        return
    assert len(table.executed) == nth + 1
    if ended.outcome == "aborted":
        assert ended.reason == f"{victim}_died"
    else:  # the answer that ended the episode was there before the death was noticed
        assert ended.outcome in ("grasped", "failed")
        assert not isinstance(table.executed[-1].verb, Inform)


@settings(deadline=None, max_examples=25)
@given(tables(), st.integers(0, 6))
def test_a_stop_is_the_last_thing_that_happens(table: Table, nth: int) -> None:
    names = (*INFORMS, "grasp", "look", "deliver", "putback")
    table.fails = {}

    def stop(_: Command) -> None:
        if len(table.executed) == nth + 1:
            table.fails = {name: ["stopped"] * 99 for name in names}

    table.on_execute = stop
    with scripted_cell(table) as cell:
        _, ended = episode(cell, "the red object", "extended")
    if len(table.executed) > nth:
        assert ended.outcome == "stopped"
        assert len(table.executed) == nth + 1
