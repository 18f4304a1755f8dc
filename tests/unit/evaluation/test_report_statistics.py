"""The report's statistics obey their laws, and reproduce what is known in closed form."""

import math
from collections.abc import Sequence

import made_up_results
import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from surefetch.common.errors import BadInput
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.reporting import (
    commitment,
    comparisons,
    coverage,
    pairs,
    plan,
    reliability,
)
from surefetch.evaluation.reporting.paper_numbers import ABLATIONS, BASELINES, PaperRow
from surefetch.evaluation.running.metrics import VERDICTS, Verdict, wilson

PRINTED = {
    "roboexp": (28.0, 14.3, 47.6, 14.2839, 47.5766),
    "dovsg": (29.2, 14.9, 49.2, 14.9146, 49.1677),
    "introplan": (48.0, 30.0, 66.5, 30.0313, 66.5015),
    "actpermoma": (25.0, 12.0, 44.9, 11.9994, 44.8994),
    "full": (76.0, 56.6, 88.5, 56.5703, 88.5037),
    "a1": (72.0, 52.4, 85.7, 52.4234, 85.7161),
    "a2": (72.0, 52.4, 85.7, 52.4234, 85.7161),
    "a3": (80.0, 60.9, 91.1, 60.8690, 91.1394),
    "a4": (84.0, 65.3, 93.6, 65.3464, 93.5965),
    "a5": (76.0, 56.6, 88.5, 56.5703, 88.5037),
    "a6": (76.0, 56.6, 88.5, 56.5703, 88.5037),
    "a7": (52.0, 33.5, 70.0, 33.4985, 69.9687),
    "a8": (68.0, 48.4, 82.8, 48.4103, 82.7948),
}
ROWS: dict[str, PaperRow] = {**BASELINES, **ABLATIONS}
verdicts = st.sampled_from(VERDICTS)
shares = st.floats(0.0, 1.0)


@pytest.mark.parametrize("name", PRINTED)
def test_every_interval_that_the_paper_prints_is_wilsons(name: str) -> None:
    k, n = ROWS[name].total
    rate, low, high, low_exact, high_exact = PRINTED[name]
    found = [100 * k / n, *(100 * bound for bound in wilson(k, n))]
    assert [round(value, 1) for value in found] == [rate, low, high]
    assert found[1:] == pytest.approx([low_exact, high_exact], abs=1e-4)


@given(st.lists(shares, max_size=9))
@settings(deadline=None)
def test_holm_never_lowers_a_p_and_keeps_their_order(p_values: list[float]) -> None:
    corrected = pairs.holm(p_values)
    assert all(p <= c <= 1.0 for p, c in zip(p_values, corrected, strict=True))
    ordered = [c for _, c in sorted(zip(p_values, corrected, strict=True))]
    assert ordered == sorted(ordered)


def test_holm_is_the_textbooks() -> None:
    assert pairs.holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])


@given(st.lists(st.tuples(verdicts, verdicts), min_size=1, max_size=30))
@settings(deadline=None)
def test_swapping_two_policies_turns_their_difference_around(
    both: list[tuple[Verdict, Verdict]],
) -> None:
    first = made_up_results.episodes([a for a, _ in both])
    second = made_up_results.episodes([b for _, b in both])
    there, back = pairs.paired(first, second), pairs.paired(second, first)
    assert (there.only_first, there.only_second) == (back.only_second, back.only_first)
    assert there.p_mcnemar == back.p_mcnemar
    assert there.psi == back.psi <= 1.0
    assert there.extra_cost == pytest.approx(-back.extra_cost)
    ratio, inverse = pairs.odds_ratio(there), pairs.odds_ratio(back)
    if ratio is not None and inverse is not None and 0.0 < ratio < math.inf:
        assert ratio * inverse == pytest.approx(1.0)


@given(st.lists(verdicts, min_size=1, max_size=12))
@settings(deadline=None, max_examples=20)
def test_a_policy_does_not_differ_from_itself(found: list[Verdict]) -> None:
    same = made_up_results.episodes(found)
    difference = comparisons.difference(same, same)
    assert difference.gain == 0.0
    assert difference.success == (0.0, 0.0)
    assert difference.pairs.p_mcnemar == difference.p_cost == 1.0
    assert difference.p_worse < 0.001


def test_policies_on_other_scenes_are_not_compared() -> None:
    with pytest.raises(BadInput, match="same scenes"):
        pairs.paired(
            made_up_results.episodes(["success"]), made_up_results.episodes(["success"] * 2)
        )


def test_resampling_within_families_never_mixes_them() -> None:
    values = np.array([1.0, 1.0, 0.0, 0.0])
    families = np.array(["a", "a", "b", "b"])
    means = pairs.resampled_means(values, families, 200, np.random.default_rng(0))
    assert np.all(means == 0.5)


def test_the_resampled_interval_is_near_the_normal_one() -> None:
    values = np.array([1.0] * 60 + [0.0] * 40)
    means = pairs.resampled_means(
        values, np.full(100, "a"), plan.DRAWS, np.random.default_rng(plan.SEED)
    )
    low, high = pairs.interval(means)
    half = 1.96 * math.sqrt(0.6 * 0.4 / 100)
    assert (low, high) == pytest.approx((0.6 - half, 0.6 + half), abs=0.015)


@given(st.lists(st.integers(-8, 8), min_size=1, max_size=8))
@settings(deadline=None, max_examples=25)
def test_the_sign_flip_p_agrees_with_all_flips(differences: list[int]) -> None:
    values = np.array(differences, np.float64)
    drawn = pairs.p_sign_flip(values, 4000, np.random.default_rng(1))
    signs = np.array(np.meshgrid(*[[1, -1]] * len(values))).reshape(len(values), -1)
    exact = float(np.mean(np.abs(values @ signs) >= abs(values.sum()) - 1e-9))
    assert drawn == pytest.approx(exact, abs=0.04)


def test_the_odds_ratio_of_one_family_is_that_of_its_table() -> None:
    first = made_up_results.episodes(made_up_results.so_many(success=5, false_defer=5))
    second = made_up_results.episodes(made_up_results.so_many(success=2, false_defer=8))
    one_family = [
        [msgspec.structs.replace(e, family="partial", seed=n) for n, e in enumerate(of)]
        for of in (first, second)
    ]
    assert pairs.odds_ratio(pairs.paired(*one_family)) == pytest.approx((5 / 5) / (2 / 8))


def test_a_test_without_data_makes_no_other_p_smaller() -> None:
    played = {
        plan.OURS: made_up_results.episodes(["success"] * 40),
        plan.PAPER_METHOD: made_up_results.episodes(["success", "false_defer"] * 20),
    }
    found = comparisons.compare(played, plan.GROUPS[0])
    against = next(one for one in found if one.second == plan.PAPER_METHOD)
    assert against.p is not None
    assert against.p_holm == pytest.approx(min(1.0, 7 * against.p))
    assert against.holds
    others = [one for one in found if one is not against]
    assert all(one.p is None and one.p_holm is None and one.holds is None for one in others)


def test_a_worse_policy_is_never_said_to_be_better() -> None:
    played = {
        plan.OURS: made_up_results.episodes(["false_defer"] * 40),
        plan.PAPER_METHOD: made_up_results.episodes(["success"] * 40),
    }
    found = comparisons.compare(played, plan.GROUPS[0])[0]
    assert found.p_holm is not None
    assert found.p_holm < 0.001
    assert found.holds is False


def test_cheaper_alone_is_not_enough_where_success_must_not_be_worse() -> None:
    group = next(group for group in plan.GROUPS if group.name == "tertiary")
    cheap_and_bad = made_up_results.so_many(success=30, stalled=10)
    played = {
        plan.OURS: [
            msgspec.structs.replace(e, realized_cost=0.0)
            for e in made_up_results.episodes(cheap_and_bad)
        ],
        group.against[0]: made_up_results.episodes(["success"] * 40),
    }
    found = comparisons.compare(played, group)[0]
    assert found.difference is not None
    assert found.difference.p_cost < 0.001
    assert found.p is not None
    assert found.p > 0.9
    assert found.holds is False


@given(st.lists(st.tuples(verdicts, shares), min_size=1, max_size=30))
@settings(deadline=None)
def test_coverage_grows_as_the_threshold_falls(given_: list[tuple[Verdict, float]]) -> None:
    played = _committed(given_)
    points = commitment.curve(played)
    assert [p.threshold for p in points] == sorted({p.threshold for p in points}, reverse=True)
    assert [p.coverage for p in points] == sorted(p.coverage for p in points)
    assert all(0.0 <= p.risk <= 1.0 and p.coverage <= 1.0 for p in points)
    area = commitment.area(points)
    assert area is None or 0.0 <= area <= 1.0


def test_the_surest_grasps_come_first() -> None:
    points = commitment.curve(
        _committed([("success", 0.9), ("wrong_object", 0.6), ("success", 0.6), ("success", 0.3)])
    )
    assert [p.coverage for p in points] == pytest.approx([0.25, 0.75, 1.0])
    assert [p.risk for p in points] == pytest.approx([0.0, 1 / 3, 0.25])
    assert commitment.risk_at(points, 0.7) == pytest.approx(1 / 3)
    assert commitment.risk_at(points[:1], 0.8) is None


def test_a_grasp_that_was_not_tried_is_judged_by_the_track_it_would_have_taken() -> None:
    deferred = made_up_results.episode("false_defer", commit_p=0.1)
    assert commitment.commitment(deferred) == commitment.Commitment(0.1, True, True)
    sure = made_up_results.episode("false_defer", commit_p=0.8)
    assert commitment.commitment(sure) == commitment.Commitment(0.8, False, True)
    assert commitment.commitment(made_up_results.episode("stalled", commit_p=0.0)) is None


@given(st.lists(shares, min_size=1, max_size=25), st.lists(shares, min_size=3, max_size=60))
@settings(deadline=None, max_examples=30)
def test_a_smaller_alpha_covers_at_least_as_often(
    beliefs: list[float], scores: list[float]
) -> None:
    steps = [msgspec.structs.replace(made_up_results.STEP, p_true=p) for p in beliefs]
    played = [made_up_results.episode(steps=[step], seed=n) for n, step in enumerate(steps)]
    found = coverage.at_all_levels(played, scores)
    held = [one.held for one in found]
    assert held == sorted(held, reverse=True)
    assert all(0 <= one.held <= one.n == len(played) for one in found)


def test_coverage_is_as_promised_for_exchangeable_episodes() -> None:
    rng = np.random.default_rng(5)
    episodes = [
        made_up_results.episode(
            seed=n, steps=[msgspec.structs.replace(made_up_results.STEP, p_true=1.0 - s)]
        )
        for n, s in enumerate(rng.beta(1, 5, 2000).tolist())
    ]
    found = coverage.at_all_levels(episodes, rng.beta(1, 5, 500).tolist())
    for one in found:
        spread = 3.5 * math.sqrt(float(one.alpha) * (1 - float(one.alpha)) * (1 / 500 + 1 / 2000))
        assert one.share == pytest.approx(1 - float(one.alpha), abs=spread)


def test_an_episode_is_covered_only_if_every_step_is() -> None:
    lost = msgspec.structs.replace(made_up_results.STEP, z_true="unobs", p_true=0.05)
    played = [
        made_up_results.episode(),
        made_up_results.episode(seed=1, steps=[made_up_results.STEP, lost]),
    ]
    found = coverage.observed(played, coverage.ALPHAS[4], 500)
    assert found is not None
    assert (found.held, found.n) == (1, 2)
    k = stats.beta.ppf([0.05, 0.95], 451, 50)
    assert found.band == pytest.approx(tuple(k), abs=1e-6)


def test_a_belief_that_is_always_right_and_sure_has_no_error() -> None:
    sure = msgspec.structs.replace(
        made_up_results.STEP, belief={"1:inside": 1.0}, unobs=0.0, abs=0.0, p_true=1.0
    )
    found = reliability.of([sure] * 20)
    assert (found.expected_error, found.brier, found.log_score) == (0.0, 0.0, 0.0)
    wrong = msgspec.structs.replace(sure, z_true="abs", p_true=0.0)
    assert reliability.of([wrong] * 20).brier == pytest.approx(2.0)
    assert sum(b.n for b in reliability.of([sure] * 7 + [wrong] * 16).bins) == 23


def _committed(given_: Sequence[tuple[Verdict, float]]) -> list[EpisodeResult]:
    return [
        msgspec.structs.replace(
            e, commit_p=p, grasps=tuple(msgspec.structs.replace(g, p=p) for g in e.grasps)
        )
        for n, (verdict, p) in enumerate(given_)
        for e in [made_up_results.episode(verdict, seed=n)]
    ]
