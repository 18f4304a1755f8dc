"""What one look is: cover state, viewing condition, and whether it gave what it was taken for."""

from hypothesis import given, settings
from hypothesis import strategies as st
from scripted_table import CELL, VIEWS

from surefetch.common.messages import CoverState
from surefetch.planner.actions import State
from surefetch.planner.looks import BETWEEN, condition, cover_after, gives_what_it_promised

states: st.SearchStrategy[State] = st.sampled_from(("open", "covered"))
covers: st.SearchStrategy[CoverState] = st.sampled_from(("open", "covered", "unknown"))
views = st.sampled_from((*VIEWS, None))
rows = st.sampled_from(CELL.informs)
REMOVE = next(row for row in CELL.informs if row.kind == "remove_cover")


@settings(deadline=None)
@given(states, st.lists(covers))
def test_the_cover_is_as_it_was_last_seen(before: State, seen: list[CoverState]) -> None:
    state = before
    for cover in seen:
        state = cover_after(state, cover)
    known = [cover for cover in seen if cover != "unknown"]
    assert state == (known[-1] if known else before)


@settings(deadline=None)
@given(views, states)
def test_a_cover_is_off_only_when_it_is_seen_to_be(view: str | None, cover: State) -> None:
    given_ = gives_what_it_promised(REMOVE, view, cover)
    assert given_ == (view == REMOVE.view and cover == "open")


@settings(deadline=None)
@given(rows, views, states)
def test_a_view_gives_nothing_from_elsewhere(row: object, view: str | None, cover: State) -> None:
    for inform in CELL.informs:
        if view != inform.view:
            assert not gives_what_it_promised(inform, view, cover)


@settings(deadline=None)
@given(views, st.none() | rows, states)
def test_the_condition_is_the_views_own_but_after_a_verified_removal(
    view: str | None, tried: object, cover: State
) -> None:
    row = next((r for r in CELL.informs if r is tried), None)
    q = condition(CELL.informs, view, row, cover)
    if view is None:
        assert q == BETWEEN
    elif row is REMOVE and view == REMOVE.view and cover == "open":
        assert q == "after_removal"
    else:
        assert q == view
