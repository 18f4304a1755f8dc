"""Oracle and hindsight: nothing is above them, and they succeed only by what can be done."""

import pytest
from recorded_table import record
from replayed_table import NEVER_FAILS, TABLES, evaluated

from surefetch.evaluation.policies.registry import HINDSIGHT, ORACLE
from surefetch.evaluation.replaying.evaluate import Conditions
from surefetch.evaluation.replaying.outcomes import Rates
from surefetch.planner.profiles import PROFILES


def test_the_oracle_opens_only_for_what_is_under_the_cover() -> None:
    covered = TABLES["it is under the cover"]
    scenes = [record(covered, wanted=w, seed=100_000 + n) for n, w in enumerate((0, 1, None))]
    episodes = evaluated(scenes, [ORACLE], NEVER_FAILS)[ORACLE]
    assert [e.verdict for e in episodes] == ["success"] * 3
    assert [e.n_actions for e in episodes] == [2, 1, 0]
    assert [e.outcome for e in episodes] == ["grasped", "grasped", "deferred"]
    assert episodes[0].cost == pytest.approx(0.168)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("of", TABLES)
def test_whatever_looking_and_grasping_comes_to_hindsight_comes_to(of: str, profile: str) -> None:
    """Whichever thing is wanted, or none; outcomes are drawn, and a failed grasp is one for all."""
    things = len(TABLES[of].things)
    lookers = ["greedy", "exhaustive-look", "best-fixed", "always-defer"]
    scenes = [
        record(TABLES[of], wanted=wanted, seed=100_000 + 2 * n + k)
        for k in range(2)
        for n, wanted in enumerate((None, *range(things)))
    ]
    conditions = Conditions(rates=Rates(0.7, 0.7, 0.7))
    played = evaluated(scenes, [*lookers, HINDSIGHT], conditions, profile)
    for n, best in enumerate(played[HINDSIGHT]):
        assert (best.policy, best.profile) == (HINDSIGHT, profile)
        for name in lookers:
            other = played[name][n]
            if other.verdict == "success":
                assert best.verdict == "success"
                assert best.realized_cost <= other.realized_cost


def test_hindsight_opens_only_where_opening_shows_the_target() -> None:
    covered = TABLES["it is under the cover"]
    scenes = [record(covered, wanted=w, seed=100_000 + n) for n, w in enumerate((0, None))]
    under, absent = evaluated(scenes, [HINDSIGHT], NEVER_FAILS)[HINDSIGHT]
    assert under.actions[0] == "remove_cover"
    assert under.verdict == absent.verdict == "success"
    assert absent.actions == ("defer",)
