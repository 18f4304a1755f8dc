"""What comes of actions, drawn or as it was measured, and episodes that leave their recording."""

from collections.abc import Mapping, Sequence

import pytest
from recorded_table import numbers, record
from replayed_table import NEVER_FAILS, TABLES, evaluated
from scripted_table import CELL

from surefetch.evaluation.policies.registry import ORACLE
from surefetch.evaluation.recordings.measured import Attempt, Measured
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import contender
from surefetch.evaluation.replaying.episode import OUT_OF_RECORDING, Played
from surefetch.evaluation.replaying.evaluate import Conditions, evaluate, world_of
from surefetch.evaluation.replaying.outcomes import Drawn, Rates
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import ready
from surefetch.evaluation.replaying.sitting import Sitting
from surefetch.planner.profiles import PROFILES


def test_the_first_try_comes_out_the_same_whenever_it_is_made() -> None:
    tables = [
        record(TABLES["one is clear"], wanted=0, seed=seed) for seed in range(100_000, 100_200)
    ]
    labels = ("greedy", "exhaustive-look", ORACLE)
    played = evaluated(tables, labels, Conditions(rates=Rates(view=1.0, grasp=0.5)), "paper")
    ends = [[episode.verdict for episode in played[label]] for label in labels]
    assert ends[0] == ends[1] == ends[2]
    assert 60 < ends[0].count("grasp_failed") < 140


@pytest.mark.parametrize(("rate", "low", "high"), [(0.0, 0, 0), (0.9, 420, 480), (1.0, 500, 500)])
def test_outcomes_come_at_their_rate(rate: float, low: int, high: int) -> None:
    drawn = [Drawn("partial", seed, Rates(grasp=rate)).grasps("b", 1) for seed in range(500)]
    assert low <= sum(outcome.done for outcome in drawn) <= high


def test_another_draw_gives_other_outcomes_at_the_same_rate() -> None:
    draws = [
        [Drawn("partial", seed, Rates(grasp=0.5), k).grasps("b", 1).done for seed in range(400)]
        for k in range(3)
    ]
    assert all(140 < sum(draw) < 260 for draw in draws)
    assert all(sum(a != b for a, b in zip(draws[0], d, strict=True)) > 100 for d in draws[1:])


def test_where_no_body_is_nothing_is_grasped() -> None:
    assert not Drawn("partial", 1, Rates(grasp=1.0)).grasps(None, 1).done


def attempt(done: bool, moved_m: float = 0.0) -> Attempt:
    return Attempt(done=done, why="", moved_m=moved_m, turned_deg=0.0, duration_s=7.0)


def measured(removals: Sequence[Attempt] = (), grasps: Sequence[Attempt] = ()) -> Measured:
    return Measured(
        format=1, family="partial", seed=1, removals=tuple(removals), grasps=tuple(grasps)
    )


def as_measured(
    of: str, told: Measured, label: str = "ours", profile: str = "extended"
) -> EpisodeResult:
    scene = ready(*record(TABLES[of], wanted=0), measured=told)
    one = contender(label, profile, {name: numbers(name) for name in PROFILES})
    (episode,) = evaluate(scene, [one], CELL, Conditions("measured"))
    return episode


def test_measured_outcomes_come_in_their_order_with_their_durations() -> None:
    told = measured(grasps=[attempt(False), attempt(True)])
    episode = as_measured("one is clear", told, "greedy")
    assert [action.endswith("(failed)") for action in episode.actions] == [True, False]
    assert (episode.verdict, episode.duration_s) == ("success", 14.0)


def test_a_failure_that_moved_nothing_much_leaves_the_recording_valid() -> None:
    told = measured(grasps=[attempt(False, moved_m=0.0029), attempt(True)])
    assert as_measured("one is clear", told).verdict == "success"


def test_after_a_failure_that_moved_bodies_nothing_can_be_seen_any_more() -> None:
    told = measured(grasps=[attempt(False, moved_m=0.0031), attempt(True)])
    episode = as_measured("one is clear", told)
    assert (episode.verdict, episode.reason) == ("aborted", OUT_OF_RECORDING)
    assert "grasp failed and moved what stands there" in episode.why


def test_an_episode_that_leaves_its_recording_can_be_finished_elsewhere() -> None:
    told = measured(grasps=[attempt(False, moved_m=0.0031)])
    scene = ready(*record(TABLES["one is clear"], wanted=0), measured=told)
    numbers_of = {name: numbers(name) for name in PROFILES}
    contenders = [contender(name, "extended", numbers_of) for name in ("ours", "greedy")]

    def finish(
        sitting: Sitting, left: Played, world: RecordedWorld, beliefs: Beliefs
    ) -> tuple[Played, Mapping[str, str | None]]:
        """On a table that is as it was before."""
        assert world.disturbed is not None
        return sitting.play(world_of(scene, NEVER_FAILS), beliefs.apart(), left.turn), world.bodies

    for episode in evaluate(scene, contenders, CELL, Conditions("measured"), finish):
        assert (episode.verdict, episode.finished_live) == ("success", True)
        grasps = [action for action in episode.actions if action.startswith("grasp")]
        assert [action.endswith("(failed)") for action in grasps] == [True, False]


def test_a_failure_that_ends_the_episode_needs_nothing_more_to_be_seen() -> None:
    told = measured(grasps=[attempt(False, moved_m=0.1)])
    episode = as_measured("one is clear", told, "greedy", "paper")
    assert (episode.verdict, episode.reason) == ("grasp_failed", "grasp_failed")


def test_a_failed_removal_counts_like_a_failed_grasp() -> None:
    of, lifted = "it is under the cover", [attempt(True)]
    stays = measured(removals=[attempt(False), attempt(True)], grasps=lifted)
    assert as_measured(of, stays).actions.count("remove_cover (failed)") == 1
    moved = measured(removals=[attempt(False, moved_m=0.01), attempt(True)], grasps=lifted)
    assert as_measured(of, moved).reason == OUT_OF_RECORDING


def test_what_was_not_measured_is_not_made_up() -> None:
    assert "was not measured" in as_measured("one is clear", measured()).why


def test_the_oracle_suffers_what_was_measured() -> None:
    told = measured(grasps=[attempt(False, moved_m=1.0), attempt(True)])
    assert as_measured("one is clear", told, ORACLE).verdict == "success"
    assert as_measured("one is clear", told, ORACLE, "paper").verdict == "grasp_failed"
    assert as_measured("one is clear", measured(), ORACLE).verdict == "grasp_failed"
    never_lifted = as_measured("it is under the cover", measured(), ORACLE)
    assert never_lifted.verdict == "interaction_failed"
