"""A failure that is injected is only reported, in replay as live."""

import pytest
from recorded_table import record
from replayed_table import TABLES, names, replayed
from scripted_table import CELL, Table, scripted_cell

from surefetch.common.injections import KINDS, kind_of
from surefetch.common.messages import Defer, Ended, Grasp, Inform, InjectedKind, Injection
from surefetch.evaluation.policies.planned import Planned
from surefetch.planner.profiles import PROFILES


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("of", TABLES)
def test_an_injected_failure_changes_only_what_is_reported(kind: InjectedKind, of: str) -> None:
    """Under rules that outlive failure, the same end comes one action of this kind later."""
    recorded = record(TABLES[of], wanted=0 if TABLES[of].things else None)
    plain = replayed(Planned(), recorded)
    struck = replayed(Planned(), recorded, injected=(Injection(kind=kind, occurrence=1),))
    mine = [c for c in plain.taken if not isinstance(c, Defer) and kind_of(c, CELL) == kind]
    assert len(struck.taken) - len(plain.taken) == (1 if mine else 0)
    assert (struck.end.outcome, struck.end.track) == (plain.end.outcome, plain.end.track)
    failed = [m.report for m in struck.moments if m.report and not m.report.done]
    assert [(r.injected, r.done) for r in failed] == [(True, False)] * bool(mine)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("of", TABLES)
def test_an_injected_failure_goes_as_a_failure_that_live_services_report(
    profile: str, of: str
) -> None:
    """Whatever is looked at or grasped first; the scripted arm does nothing when it fails."""
    table = TABLES[of]
    target = 0 if table.things else None
    first = next(iter(replayed(Planned(), record(table, wanted=target), profile).taken))
    kind = None if isinstance(first, Defer) else kind_of(first, CELL)
    if kind is None or isinstance(first, Defer):
        return
    name = first.name if isinstance(first, Inform) else "grasp"
    live = Table(table.things, covered=table.covered, fails={name: ["failed"]})
    with scripted_cell(live) as cell:
        accepted = cell.instruct(profile=profile, after_grasp="hold")
        ended = cell.events()[-1].happening
    assert isinstance(ended, Ended)
    struck = replayed(
        Planned(), record(table, wanted=target, target=accepted.target), profile,
        injected=(Injection(kind=kind, occurrence=1),),
    )  # fmt: skip
    moved = [a.action for a in ended.actions if a.action not in ("look", "put_back")]
    assert names(struck.taken) == moved
    assert (struck.end.outcome, struck.end.reason) == (ended.outcome, ended.reason)


def test_an_injected_failure_uses_up_no_attempt() -> None:
    """The first real attempt fails; reported failures before it do not take its place."""
    recorded = record(TABLES["one is clear"], wanted=0)
    played = replayed(
        Planned(),
        recorded,
        fails={"grasp": ["failed"]},
        injected=(Injection(kind="grasp", occurrence=1),),
    )
    reports = [m.report for m in played.moments if isinstance(m.choice, Grasp)]
    assert [(r.done, r.injected) for r in reports if r] == [
        (False, True), (False, False), (True, False)
    ]  # fmt: skip
