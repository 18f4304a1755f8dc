"""Episodes over four services and a scripted table: every way to go wrong, at every point."""

import itertools
import threading
from collections.abc import Sequence
from typing import Any, TypeVar

import pytest
from scripted_table import (
    CELL,
    Table,
    action,
    parameters,
    scripted_cell,
    thing,
    thing_inside,
)

from surefetch.common.errors import BadInput, PeerMissing, Refused
from surefetch.common.messages import (
    Accepted,
    Believed,
    Captured,
    Command,
    Decided,
    Ended,
    Event,
    Grasp,
    Inform,
    Message,
    Target,
)
from surefetch.planner import episode
from surefetch.planner.account import Account
from surefetch.planner.crew import Crew
from surefetch.planner.profiles import Policy, Profile, choose
from surefetch.planner.search import solve
from surefetch.planner.situation import Errand

M = TypeVar("M", bound=Message)


def of(kind: type[M], events: Sequence[Event]) -> list[M]:
    return [e.happening for e in events if isinstance(e.happening, kind)]


def done(table: Table) -> list[str]:
    return [action(command) for command in table.executed]


CLEAR = (thing(0.8, 0.2), thing(0.8, -0.2, "other"), thing(1.2, -0.2, "other"))
TWINS = (thing(0.8, 0.2), thing(0.8, -0.2))


def test_the_object_meant_is_grasped_verified_and_delivered() -> None:
    with scripted_cell(table := Table(CLEAR)) as cell:
        ended = cell.fetch()
    assert (ended.outcome, ended.reason, ended.delivered) == ("grasped", "verified", True)
    assert table.gone == [CLEAR[0]]
    assert done(table)[-3:] == ["grasp", "look", "deliver"]
    assert "by finger width and by a look" in ended.because


def test_the_events_tell_everything_without_a_gap() -> None:
    with scripted_cell(Table(CLEAR)) as cell:
        accepted = cell.instruct()
        events = cell.events()
    assert [e.seq for e in events] == list(range(len(events)))
    assert {e.episode for e in events} == {accepted.episode}
    assert events[0].happening == accepted
    (ended,) = of(Ended, events)
    assert len(of(Decided, events)) == len(ended.steps)
    assert [s.belief for s in ended.steps] == [b.belief for b in of(Believed, events)]
    assert [s.q_values for s in ended.steps] == [d.q_values for d in of(Decided, events)]
    assert ended.q_hat == 0.9
    assert ended.durations["motion"] == len(ended.actions)
    assert {"executor", "perception", "belief", "planner"} <= ended.durations.keys()


def test_what_was_understood_is_told_before_anything_moves() -> None:
    with scripted_cell(table := Table(CLEAR)) as cell:
        accepted = cell.instruct("the red cube inside the box")
        assert accepted.understood == "a red cube, inside the box"
        cell.events()
    assert table.executed


@pytest.mark.parametrize(
    ("sentence", "words"),
    [
        ("the green cube", "green"),
        ("", "empty"),
        ("the red blue cube", "two values"),
        ("the cube inside and outside the box", "inside"),
    ],
)
def test_a_sentence_that_is_not_understood_is_bad_input_and_nothing_moves(
    sentence: str, words: str
) -> None:
    with scripted_cell(table := Table(CLEAR)) as cell:
        with pytest.raises(Refused, match=words) as refused:
            cell.instruct(sentence)
        assert cell.fetch().outcome == "grasped"  # the planner is free for the next one
    assert refused.value.exit_code == 2
    assert table.n_frames > 0


def test_twins_end_in_a_defer_that_names_both() -> None:
    with scripted_cell(table := Table(TWINS)) as cell:
        ended = cell.fetch()
    assert (ended.outcome, ended.reason) == ("deferred", "nothing_left")
    assert "T1 outside" in ended.because
    assert "T2 outside" in ended.because
    assert "still rivals" in ended.because
    assert table.gone == []
    assert done(table) == ["look", "right", "close_high"]


def test_what_could_not_be_read_is_said() -> None:
    with scripted_cell(Table([thing(0.8, 0.2, "unread"), thing(0.8, -0.2, "unread")])) as cell:
        ended = cell.fetch()
    assert ended.outcome == "deferred"
    assert "T1 and T2 could not be read for sure" in ended.because


def test_an_object_where_it_was_not_asked_for_is_named_and_left_alone() -> None:
    with scripted_cell(table := Table([thing(0.8, 0.2), thing_inside("other")])) as cell:
        ended = cell.fetch("the red object inside the box")
    assert ended.outcome == "deferred"
    assert "T1 outside" in ended.because
    assert "but inside the box was asked for" in ended.because
    assert table.gone == []


def test_an_absent_object_ends_in_a_defer_after_looking() -> None:
    with scripted_cell(table := Table([thing(0.8, 0.2, "other")])) as cell:
        ended = cell.fetch()
    assert ended.outcome == "deferred"
    assert done(table) == ["look", "right", "close_high"]


def test_nothing_perceived_at_all_ends_in_a_defer_that_says_so() -> None:
    with scripted_cell(table := Table([], covered=None)) as cell:
        ended = cell.fetch()
    assert ended.outcome == "deferred"
    assert "nothing was detected" in ended.because
    assert done(table) == ["look", "right", "close_high"]
    assert ended.steps[0].belief == {"unobs": pytest.approx(22 / 27), "abs": pytest.approx(5 / 27)}


def test_a_scene_without_a_container_counts_as_open() -> None:
    with scripted_cell(table := Table(CLEAR, covered=None)) as cell:
        assert cell.fetch().outcome == "grasped"
    assert "remove_cover" not in done(table)


def test_under_the_paper_rules_a_covered_object_is_uncovered_before_any_view() -> None:
    hidden = thing_inside()
    with scripted_cell(table := Table([hidden, thing(0.7, 0.25, "other")], covered=True)) as cell:
        cell.instruct("the red object inside the box", profile="paper")
        events = cell.events()
    ended = of(Ended, events)[0]
    assert ended.outcome == "grasped"
    assert table.gone == [hidden]
    assert done(table)[:2] == ["look", "remove_cover"]
    assert [s.q for s in ended.steps][:2] == ["center", "after_removal"]
    assert [c.q for c in of(Captured, events)][:2] == ["center", "after_removal"]


def test_a_view_costs_less_than_a_cover_and_comes_first() -> None:
    hidden = thing_inside()
    with scripted_cell(table := Table([hidden, thing(0.7, 0.25, "other")], covered=True)) as cell:
        cell.instruct("the red object inside the box")
        events = cell.events()
    ended = of(Ended, events)[0]
    assert ended.outcome == "grasped"
    assert table.gone == [hidden]
    assert done(table)[:3] == ["look", "right_covered", "remove_cover"]
    assert [s.q for s in ended.steps][:3] == ["center", "right", "after_removal"]


def test_a_reported_removal_alone_opens_nothing() -> None:
    table = Table([thing_inside()], covered=True, stuck_lid=True)
    with scripted_cell(table) as cell:
        cell.instruct("the red object inside the box")
        events = cell.events()
    (ended,) = of(Ended, events)
    assert (ended.outcome, ended.reason) == ("failed", "removal_failed")
    assert done(table).count("remove_cover") == 3
    assert "after_removal" not in {s.q for s in ended.steps}
    assert [b.q for b in of(Believed, events)] == [s.q for s in ended.steps]
    hoped_for = [c.q for c in of(Captured, events)]
    assert hoped_for.count("after_removal") == 3
    again = [s for s, q in zip(ended.steps, hoped_for, strict=True) if q == "after_removal"]
    assert all(not s.observations for s in again)


def test_under_the_paper_rules_a_removal_that_opens_nothing_ends_the_episode() -> None:
    table = Table([thing_inside()], covered=True, stuck_lid=True)
    with scripted_cell(table) as cell:
        ended = cell.fetch("the red object inside the box", "paper")
    assert (ended.outcome, ended.reason) == ("failed", "removal_failed")
    assert done(table).count("remove_cover") == 1


def test_a_view_seen_again_does_not_count_again() -> None:
    table = Table(CLEAR, fails={"grasp": ["failed"]})
    with scripted_cell(table) as cell:
        cell.instruct()
        events = cell.events()
    ended = of(Ended, events)[0]
    assert ended.outcome == "grasped"
    seen = [(c.view, believed.counted) for c, believed in _looks(events)]
    counted_views = [view for view, counted in seen if counted]
    assert len(counted_views) == len(set(counted_views))
    assert any(not counted for _, counted in seen)


def _looks(events: Sequence[Event]) -> list[tuple[Captured, Believed]]:
    by_step: dict[int, list[Any]] = {}
    for e in events:
        if isinstance(e.happening, Captured | Believed):
            by_step.setdefault(e.step, []).append(e.happening)
    return [(told[0], told[1]) for told in by_step.values()]


VIEWS_FAIL = {"right": ["failed"] * 9, "close_high": ["failed"] * 9}
UNSURE = (thing(0.8, 0.2, "unread"), thing(0.8, -0.2, "unread"))


def test_a_failed_view_is_tried_three_times_then_replaced_and_never_ends_in_a_defer() -> None:
    table = Table(UNSURE, fails=VIEWS_FAIL)
    with scripted_cell(table) as cell:
        ended = cell.fetch()
    assert (ended.outcome, ended.reason) == ("failed", "view_failed")
    assert done(table).count("right") == 3
    assert done(table).count("close_high") == 3


def test_one_failed_view_is_replaced_by_the_other() -> None:
    things = [thing(0.8, 0.2, "unread", close_high="match"), thing(0.8, -0.2, "other")]
    table = Table(things, fails={"right": ["failed"] * 9})
    with scripted_cell(table) as cell:
        ended = cell.fetch()
    assert ended.outcome == "grasped"
    assert done(table).count("close_high") == 1


def test_a_view_that_works_at_the_second_try_is_used_once() -> None:
    table = Table(UNSURE, fails={"right": ["failed"], "close_high": ["refused"]})
    with scripted_cell(table) as cell:
        ended = cell.fetch()
    assert ended.outcome == "deferred"
    assert done(table).count("right") == 2
    assert done(table).count("close_high") == 2


def test_an_infeasible_view_is_out_and_may_leave_nothing_but_a_defer() -> None:
    table = Table(UNSURE, infeasible=frozenset({"right", "close_high"}))
    with scripted_cell(table) as cell:
        ended = cell.fetch()
    assert ended.outcome == "deferred"
    assert "right is out of the robot's power (reach)" in ended.because
    assert done(table) == ["look"]


def test_under_the_paper_rules_one_failed_view_ends_the_episode() -> None:
    table = Table(UNSURE, fails={"right": ["failed"]})
    with scripted_cell(table) as cell:
        ended = cell.fetch(profile="paper")
    assert (ended.outcome, ended.reason) == ("failed", "view_failed")
    assert done(table) == ["look", "right"]


def test_a_failed_removal_is_tried_again() -> None:
    table = Table([thing_inside()], covered=True, fails={"remove_cover": ["failed", "failed"]})
    with scripted_cell(table) as cell:
        ended = cell.fetch("the red object inside the box")
    assert ended.outcome == "grasped"
    assert done(table).count("remove_cover") == 3


def test_a_failed_grasp_is_looked_at_again_and_tried_three_times() -> None:
    table = Table(CLEAR, fails={"grasp": ["failed"] * 9})
    with scripted_cell(table) as cell:
        ended = cell.fetch()
    assert (ended.outcome, ended.reason, ended.track) == ("failed", "grasp_failed", 1)
    assert done(table).count("grasp") == 3
    between = done(table)[done(table).index("grasp") :]
    assert between == ["grasp", "look", "grasp", "look", "grasp"]


def test_under_the_paper_rules_one_failed_grasp_ends_the_episode() -> None:
    table = Table(CLEAR, fails={"grasp": ["failed"]})
    with scripted_cell(table) as cell:
        ended = cell.fetch(profile="paper")
    assert (ended.outcome, ended.reason) == ("failed", "grasp_failed")
    assert done(table)[-1] == "grasp"


def test_an_object_that_is_still_there_was_not_grasped() -> None:
    table = Table(CLEAR, slips=1)
    with scripted_cell(table) as cell:
        ended = cell.fetch()
    assert ended.outcome == "grasped"
    assert done(table).count("grasp") == 2
    assert "putback" in done(table)
    with scripted_cell(table := Table(CLEAR, slips=1)) as cell:
        ended = cell.fetch(profile="paper")
    assert (ended.outcome, ended.reason) == ("failed", "grasp_failed")
    assert "still in its old place" in ended.because


def test_a_place_that_cannot_be_seen_again_is_said_and_the_fingers_are_believed() -> None:
    table = Table(CLEAR, fails={"look": ["done", "refused"]})
    with scripted_cell(table) as cell:
        ended = cell.fetch()
    assert ended.outcome == "grasped"
    assert "by finger width alone" in ended.because


def test_a_delivery_that_fails_is_still_a_grasp() -> None:
    with scripted_cell(Table(CLEAR, fails={"deliver": ["failed"]})) as cell:
        ended = cell.fetch()
    assert (ended.outcome, ended.delivered) == ("grasped", False)
    assert "not delivered" in ended.because


@pytest.mark.parametrize(("after", "last"), [("hold", "look"), ("return", "putback")])
def test_what_follows_the_grasp_is_as_asked_for(after: Any, last: str) -> None:
    with scripted_cell(table := Table(CLEAR)) as cell:
        cell.instruct(after_grasp=after)
        ended = of(Ended, cell.events())[0]
    assert (ended.outcome, ended.delivered) == ("grasped", None)
    assert done(table)[-1] == last


def test_an_infeasible_grasp_is_not_tried() -> None:
    with scripted_cell(table := Table(CLEAR, infeasible=frozenset({"grasp"}))) as cell:
        ended = cell.fetch()
    assert ended.outcome == "deferred"
    assert "but it cannot be: aperture, too wide" in ended.because
    assert "grasp" not in done(table)


def test_the_first_view_that_is_never_reached_ends_the_episode() -> None:
    with scripted_cell(table := Table(CLEAR, fails={"look": ["failed"] * 9})) as cell:
        ended = cell.fetch()
    assert (ended.outcome, ended.reason) == ("failed", "view_failed")
    assert table.n_frames == 0
    assert done(table) == ["look"] * 3


def test_no_more_actions_are_taken_than_the_profile_allows() -> None:
    patient = Policy("patient", Profile("extended", 9, True, max_actions=4), solve)
    target = Target(noun="object", color="red")
    errand = Errand(target, "deliver", patient, parameters("extended"), CELL)
    table = Table(UNSURE, fails=VIEWS_FAIL)
    with scripted_cell(table) as cell:
        account = Account(cell.operator, "by hand")
        ids = map(str, itertools.count())
        crew = Crew(cell.operator, account, new_id=lambda: next(ids), cancelled=lambda: False)
        ended = episode.run(crew, account, errand)
    assert (ended.outcome, ended.reason) == ("failed", "step_limit")
    assert sum(isinstance(c.verb, Inform | Grasp) for c in table.executed) == 4


@pytest.mark.parametrize("at", ["look", "right", "grasp", "deliver"])
def test_a_stop_at_the_robot_ends_the_episode_as_stopped(at: str) -> None:
    things = [thing(0.8, 0.2, "unread", right="match"), thing(0.8, -0.2, "other")]
    table = Table(things, fails={at: ["stopped"]})
    with scripted_cell(table) as cell:
        ended = cell.fetch()
    assert (ended.outcome, ended.reason) == ("stopped", "operator")
    assert done(table)[-1] == at
    assert ended.actions[-1].status == "stopped"


def test_a_cancelled_episode_ends_after_the_motion_under_way() -> None:
    moving, go_on = threading.Event(), threading.Event()

    def hold(command: Command) -> None:
        if action(command) == "right":
            moving.set()
            go_on.wait(10.0)

    with scripted_cell(table := Table(UNSURE, on_execute=hold)) as cell:
        accepted = cell.instruct()
        assert moving.wait(10.0)
        cell.cancel(accepted.episode)
        go_on.set()
        ended = of(Ended, cell.events())[0]
    assert (ended.outcome, ended.reason) == ("stopped", "operator")
    assert done(table) == ["look", "right"]
    assert ended.actions[-1].status == "done"


def test_another_episode_cannot_be_cancelled_by_mistake() -> None:
    with scripted_cell(Table(CLEAR)) as cell, pytest.raises(Refused) as refused:
        cell.cancel("nobody")
    assert refused.value.reason == "UNKNOWN_EPISODE"


def test_one_episode_at_a_time() -> None:
    moving, go_on = threading.Event(), threading.Event()

    def hold(_: Command) -> None:
        moving.set()
        go_on.wait(10.0)

    with scripted_cell(Table(CLEAR, on_execute=hold)) as cell:
        accepted = cell.instruct()
        assert moving.wait(10.0)
        with pytest.raises(Refused, match=accepted.episode) as refused:
            cell.instruct()
        go_on.set()
        assert of(Ended, cell.events())[0].outcome == "grasped"
    assert refused.value.reason == "BUSY"


@pytest.mark.parametrize(
    ("victim", "at"),
    list(itertools.product(["executor", "perception", "belief"], ["look", "right", "grasp"])),
)
def test_a_service_that_dies_in_mid_motion_aborts_at_once_by_name(victim: str, at: str) -> None:
    go_on = threading.Event()

    def kill(command: Command) -> None:
        if action(command) == at:
            cell.kill(victim)
            go_on.wait(10.0)

    things = [thing(0.8, 0.2, "unread", right="match"), thing(0.8, -0.2, "other")]
    with scripted_cell(Table(things, on_execute=kill)) as cell:
        cell.instruct()
        events = cell.events()  # while the robot still hangs in its motion
        go_on.set()
    ended = of(Ended, events)[0]
    assert (ended.outcome, ended.reason) == ("aborted", f"{victim}_died")
    assert victim in ended.because


@pytest.mark.parametrize("victim", ["executor", "perception", "belief"])
def test_a_service_that_is_not_there_is_named(victim: str) -> None:
    with scripted_cell(table := Table(CLEAR)) as cell:
        cell.kill(victim)
        if victim == "perception":
            with pytest.raises(PeerMissing, match=victim):
                cell.instruct()
        else:
            assert cell.fetch().reason == f"{victim}_died"
    assert not any(isinstance(c.verb, Inform | Grasp) for c in table.executed)


def test_a_second_episode_begins_with_a_fresh_belief() -> None:
    with scripted_cell(table := Table(TWINS)) as cell:
        first = cell.fetch()
        table.view = None
        second = cell.fetch()
    assert [s.belief for s in first.steps] == [s.belief for s in second.steps]
    assert isinstance(first, Ended)
    assert first.because == second.because


def test_profile_and_policy_must_go_together() -> None:
    assert choose("extended", "ours").profile.max_actions == 12
    assert choose("paper", "paper-method").profile.max_actions == 6
    for profile, policy in [("paper", "ours"), ("extended", "paper-method")]:
        with pytest.raises(BadInput, match="brings its own profile"):
            choose(profile, policy)
    with pytest.raises(BadInput, match="Profiles: paper, extended"):
        choose("nonsense", "ours")
    with pytest.raises(BadInput, match="Policies: ours, paper-method"):
        choose("paper", "nonsense")


def test_accepted_is_the_first_event_and_the_reply() -> None:
    with scripted_cell(Table(CLEAR)) as cell:
        reply = cell.instruct()
        assert of(Accepted, cell.events()) == [reply]
