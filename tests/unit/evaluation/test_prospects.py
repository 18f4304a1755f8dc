"""What a recording says the robot could do is what the robot says, after every order of looks."""

from itertools import permutations

import pytest
from recorded_table import numbers, record
from scripted_table import Table, thing

from surefetch.belief.episode import EpisodeBelief, rules_of, step
from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.injections import Injector
from surefetch.common.messages import Feasibility
from surefetch.common.parameters import shipped_parameters
from surefetch.evaluation.fitting import sequences
from surefetch.evaluation.recordings.histories import (
    Known,
    histories,
    known_after,
    looks_along,
)
from surefetch.evaluation.recordings.recording import Looks, Recording, State, paths, states
from surefetch.evaluation.recordings.studio import Studio
from surefetch.evaluation.replaying.beliefs import Heard
from surefetch.evaluation.replaying.live_world import LiveWorld
from surefetch.evaluation.scenes.generate import GeneratedScene, generate
from surefetch.planner.profiles import POLICIES
from surefetch.planner.situation import Errand

CELL = simulated_cell()


@pytest.fixture(scope="module")
def made() -> GeneratedScene:
    return generate("covered", 1)


@pytest.fixture(scope="module")
def recording(made: GeneratedScene) -> Recording:
    with Studio(made, CELL, "classical") as studio:
        return studio.record().recording


def known(recording: Recording, looks: Looks) -> Known:
    return known_after((state.view, recording.shot(state)) for state in looks)


@pytest.mark.parametrize(("covered", "n"), [(False, 5 + 2), (True, 30 + 5)])
def test_histories_are_those_of_all_sequences_and_of_each_state_alone(
    covered: bool, n: int
) -> None:
    found = histories(covered, CELL)
    assert len(found) == len(set(found)) == n
    along = {looks_along(p, covered, CELL) for p in paths(covered, CELL, views_while_covered=True)}
    assert set(found) == along | {(state,) for state in states(covered, CELL)}
    for n_looks, looks in enumerate(found):
        assert looks[:-1] in [(), *found[:n_looks]]


def test_the_tracks_that_are_judged_are_the_belief_s() -> None:
    table = Table([thing(0.9, -0.1), thing(0.9, 0.1, "other", right="unread")])
    recording, truth = record(table, wanted=0)
    begin = EpisodeBelief(rules_of(numbers("extended"), recording.target.relation))
    every = paths(False, CELL)
    believed = sequences.looks_along(recording, truth, every, CELL, begin, step, profile="extended")
    for path in every:
        judged = known(recording, looks_along(path, False, CELL)).tracks
        tracks = believed[path][-1].reply.tracks
        assert [(t.id, t.last_detection, t.center_world_m) for t in tracks] == [
            (t.id, t.last_detection, t.center_world_m) for t in judged
        ]


def test_after_every_history_all_tracks_and_all_that_is_left_to_do_are_judged(
    recording: Recording,
) -> None:
    assert {one.looks for one in recording.feasible} == set(histories(True, CELL))
    every = paths(True, CELL, views_while_covered=True)
    for path in every:
        one = recording.feasible_after(looks_along(path, True, CELL))
        feasibility = one.feasibility
        tracks = [t.id for t in known(recording, one.looks).tracks]
        assert [verdict.track for verdict in feasibility.grasps] == sorted(tracks)
        assert one.grasps_s.keys() == {v.track for v in feasibility.grasps if v.feasible}
        assert one.informs_s.keys() == {v.name for v in feasibility.informs if v.feasible}
        assert all(s > 0.5 for s in (*one.grasps_s.values(), *one.informs_s.values()))
        longer = {longer[-1] for longer in every if longer and longer[:-1] == path}
        assert {verdict.name for verdict in feasibility.informs} == longer


def test_what_was_seen_again_counts_once_and_unknown_looks_are_refused(
    recording: Recording,
) -> None:
    first, *_ = (shot.state for shot in recording.shots)
    assert recording.feasible_after([first, first]) == recording.feasible_after([first])
    elsewhere = State(view="center", cover="none")
    with pytest.raises(BadInput, match=r"what is feasible after center \(none\)"):
        recording.feasible_after([elsewhere])


def told(said: Feasibility) -> tuple[dict[int, bool], dict[str, bool]]:
    grasps = {verdict.track: verdict.feasible for verdict in said.grasps}
    return grasps, {verdict.name: verdict.feasible for verdict in said.informs}


def test_a_live_robot_says_the_same_and_takes_as_long(
    made: GeneratedScene, recording: Recording
) -> None:
    errand = Errand(made.target, "hold", POLICIES["ours"], shipped_parameters("extended"), CELL)
    looks: Looks = ()
    now, view = Known(), "center"
    with LiveWorld(made, errand, "classical", Injector()) as world:
        for name in ("right_covered", "remove_cover", "close_high", None):
            sight = world.see(view)
            now, looks = now.after(view, sight.seen), (*looks, sight.state)
            heard = Heard(sight.state, "-", True, now.cover == "covered")
            grasps, informs = told(world.feasible((heard,), now.estimate))
            recorded = recording.feasible_after(looks)
            assert told(recorded.feasibility)[0] == grasps
            assert told(recorded.feasibility)[1].items() <= informs.items()
            if name is not None:
                row = CELL.inform(name)
                report, view = world.inform(row), row.view
                assert report.done
                assert report.duration_s == pytest.approx(recorded.informs_s[name], rel=0.05)


def test_the_order_of_looks_that_end_in_the_same_estimate_does_not_matter(
    recording: Recording,
) -> None:
    """Numbers of tracks may differ; what is said of each body does not."""
    closed = [State(view=view, cover="closed") for view in ("right", "close_high")]
    start, end = State(view="center", cover="closed"), State(view="center", cover="open")
    said = []
    for order in permutations(closed):
        looks = (start, *order, end)
        grasps, _ = told(recording.feasible_after(looks).feasibility)
        bodies = {t.id: t.last_detection for t in known(recording, looks).tracks}
        said.append({bodies[number]: feasible for number, feasible in grasps.items()})
    one, other = said
    for body in one.keys() & other.keys():
        assert one[body] == other[body]
