"""A replayed episode is the live one, and is written down as it was played."""

from collections.abc import Callable

import msgspec
import pytest
from recorded_table import record
from replayed_table import NEVER_FAILS, TABLES, Spy, evaluated, names, replayed
from scripted_table import CELL, Table, scripted_cell

from surefetch.common.errors import BadInput
from surefetch.common.messages import Choice, Ended, Feasibility, Grasp, Inform, InformVerdict
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.planned import Planned
from surefetch.evaluation.recordings.recording import FeasibleAfter, Recording, State
from surefetch.evaluation.replaying.episode import OUT_OF_RECORDING
from surefetch.planner.profiles import PROFILES


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize(
    "fails", [{}, {"right": ["failed"]}, {"grasp": ["failed"] * 3}, {"remove_cover": ["failed"]}]
)
def test_a_replay_takes_the_actions_of_the_live_services(
    profile: str, name: str, fails: dict[str, list[str]]
) -> None:
    table = TABLES[name]
    live = Table(table.things, covered=table.covered, fails=fails)
    with scripted_cell(live) as cell:
        accepted = cell.instruct(profile=profile, after_grasp="hold")
        ended = cell.events()[-1].happening
    assert isinstance(ended, Ended)
    played = replayed(
        Planned(), record(table, wanted=0 if table.things else None, target=accepted.target),
        profile, fails,
    )  # fmt: skip
    moved = [a.action for a in ended.actions if a.action not in ("look", "put_back")]
    assert names(played.taken) == moved
    assert (played.end.outcome, played.end.reason) == (ended.outcome, ended.reason)
    assert played.end.track == ended.track


def test_what_was_not_recorded_ends_the_episode_and_is_counted() -> None:
    recording, truth = record(TABLES["it must be looked at"], wanted=0)
    short = msgspec.structs.replace(recording, shots=recording.shots[:1])
    (episode,) = evaluated([(short, truth)], ["ours"], NEVER_FAILS)["ours"]
    assert (episode.verdict, episode.reason) == ("aborted", OUT_OF_RECORDING)
    assert "partial:100000 was recorded without the view" in episode.why
    assert episode.actions == ("right",)
    assert len(episode.steps) == 1


def test_a_cover_that_only_perception_sees_leads_out_of_the_recording() -> None:
    recording, truth = record(TABLES["it is under the cover"], wanted=0)
    wrong = msgspec.structs.replace(recording, covered=False)
    shots = [
        msgspec.structs.replace(s, state=msgspec.structs.replace(s.state, cover="none"))
        for s in recording.shots[:1]
    ]
    first = msgspec.structs.replace(recording.feasible[0], looks=(shots[0].state,))
    wrong = msgspec.structs.replace(wrong, shots=tuple(shots), feasible=(first,))
    truths = [
        msgspec.structs.replace(s, state=msgspec.structs.replace(s.state, cover="none"))
        for s in truth.shots[:1]
    ]
    none = msgspec.structs.replace(truth, shots=tuple(truths))
    played = evaluated([(wrong, none)], ["exhaustive-look"], NEVER_FAILS, "paper")
    assert "where no cover is on" in played["exhaustive-look"][0].why


def after_all_looks(
    recording: Recording, change: Callable[[FeasibleAfter], FeasibleAfter]
) -> Recording:
    return msgspec.structs.replace(recording, feasible=tuple(map(change, recording.feasible)))


def test_what_the_robot_could_not_do_is_not_open() -> None:
    """Nothing can be grasped before it was seen from the right, and close_high never reached."""
    right = State(view="right", cover="none")
    unreached = InformVerdict(name="close_high", feasible=False, refusal="path", why="")

    def hinder(known: FeasibleAfter) -> FeasibleAfter:
        grasps = tuple(
            msgspec.structs.replace(v, feasible=right in known.looks)
            for v in known.feasibility.grasps
        )
        hindered = Feasibility(grasps=grasps, informs=(unreached,), duration_s=0.0)
        return msgspec.structs.replace(known, feasibility=hindered)

    recording, truth = record(TABLES["one is clear"], wanted=0)
    played = replayed(Planned(), (after_all_looks(recording, hinder), truth))
    assert names(played.taken) == ["right", "grasp"]
    spy = Spy()
    replayed(spy, (after_all_looks(recording, hinder), truth))
    assert [[row.name for row in now.informs] for now in spy.told] == [["right"], []]
    assert [bool(now.grasps) for now in spy.told] == [False, True]


def test_a_belief_without_memory_can_do_what_its_latest_look_allows() -> None:
    recording, truth = record(TABLES["it must be looked at"], wanted=0)
    alone = {known.looks for known in recording.feasible if len(known.looks) == 1}
    only = msgspec.structs.replace(
        recording, feasible=tuple(k for k in recording.feasible if k.looks in alone)
    )
    played = evaluated([(only, truth)], ["a2", "ours"], NEVER_FAILS)
    assert played["a2"][0].verdict == "success"
    assert played["ours"][0].reason == OUT_OF_RECORDING


def test_an_episode_takes_as_long_as_its_motions_and_its_perception() -> None:
    def timed(known: FeasibleAfter) -> FeasibleAfter:
        grasps_s = {v.track: 5.0 for v in known.feasibility.grasps}
        views_s = {"right": 2.0, "close_high": 1.0}
        return msgspec.structs.replace(known, informs_s=views_s, grasps_s=grasps_s)

    recording, truth = record(TABLES["it must be looked at"], wanted=0)
    shots = tuple(
        msgspec.structs.replace(
            shot, observations=msgspec.structs.replace(shot.observations, duration_s=0.5)
        )
        for shot in recording.shots
    )
    slow = after_all_looks(msgspec.structs.replace(recording, shots=shots), timed)
    played = evaluated([(slow, truth)], ["exhaustive-look"], NEVER_FAILS)
    (episode,) = played["exhaustive-look"]
    assert [action.split()[0] for action in episode.actions] == ["right", "close_high", "grasp"]
    assert episode.duration_s == pytest.approx(3 * 0.5 + 2.0 + 1.0 + 5.0)


class Careless:
    """Grasps a track that does not exist."""

    def act(self, _: Observation) -> Choice:
        return Grasp(track=99, relation="inside")


def test_an_action_that_is_not_open_is_refused() -> None:
    with pytest.raises(BadInput, match="not open to it"):
        replayed(Careless(), record(TABLES["one is clear"], wanted=0))


def test_a_look_that_fails_too_often_is_given_up() -> None:
    fails = {"right": ["failed"] * 9, "close_high": ["failed"] * 9}
    played = replayed(Planned(), record(TABLES["it must be looked at"], wanted=0), fails=fails)
    assert (played.end.outcome, played.end.reason) == ("failed", "view_failed")
    assert names(played.taken) == ["right"] * 3 + ["close_high"] * 3


class Restless:
    """Looks while it can, then grasps at one thing after the other."""

    def act(self, now: Observation) -> Choice:
        if now.informs:
            return Inform(name=now.informs[0].name)
        grasps = {grip.track: grip for grip in now.grasps}
        one = grasps[sorted(grasps)[now.n_actions % len(grasps)]]
        return Grasp(track=one.track, relation=one.relation)


def test_an_episode_ends_at_the_profile_s_last_action() -> None:
    fails = {name: ["failed"] * 2 for name in ("remove_cover", "right", "close_high", "grasp")}
    recorded = record(TABLES["it is under the cover"], wanted=0)
    played = replayed(Restless(), recorded, fails=fails)
    assert (played.end.outcome, played.end.reason) == ("failed", "step_limit")
    assert len(played.taken) == PROFILES["extended"].max_actions


def test_an_episode_is_written_down_as_it_was_played() -> None:
    scene = record(TABLES["it is under the cover"], wanted=0)
    (episode,) = evaluated([scene], ["ours"], NEVER_FAILS)["ours"]
    (grasp,) = episode.grasps
    assert (episode.policy, episode.profile, episode.variant) == ("ours", "extended", "full")
    assert "remove_cover" in episode.actions
    assert episode.actions[-1] == f"grasp {grasp.track} inside"
    assert tuple(s.action for s in episode.steps) == episode.actions
    assert {s.z_true for s in episode.steps if s.cover == "closed"} == {"unobs"}
    assert {s.z_true for s in episode.steps if s.cover == "open"} == {f"{grasp.track}:inside"}
    assert (grasp.on_target, grasp.held) == (True, True)
    assert episode.commit_p == grasp.p == episode.steps[-1].p_true
    looks = [CELL.inform(name).cost for name in episode.actions[:-1]]
    assert episode.cost == pytest.approx(sum(looks) + 0.008)
    assert all(step.because for step in episode.steps)


def test_a_defer_is_scored_by_the_best_grasp_that_was_open() -> None:
    scene = record(TABLES["two fit"], wanted=0)
    (episode,) = evaluated([scene], ["always-defer"], NEVER_FAILS)["always-defer"]
    assert (episode.verdict, episode.actions) == ("false_defer", ("defer",))
    assert episode.commit_p == max(episode.steps[0].belief.values())
    assert episode.realized_cost == pytest.approx(0.8)
