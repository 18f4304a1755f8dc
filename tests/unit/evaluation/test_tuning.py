"""Every policy tunes within one budget, and plays with what tuning chose."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES
from surefetch.evaluation.policies import registry, tuning
from surefetch.evaluation.policies.greedy import Greedy
from surefetch.evaluation.policies.tuning import Scalar, Trial

TRIALS = st.lists(
    st.builds(
        Trial,
        values=st.just({}),
        n_successes=st.integers(0, 3),
        by_family=st.just({}),
        mean_realized_cost=st.sampled_from([0.1, 0.2, 0.3]),
    ),
    min_size=1,
)


@pytest.mark.parametrize("name", registry.POLICIES)
def test_every_policy_keeps_the_budget_and_can_be_made_with_all_that_is_tried(name: str) -> None:
    entry = registry.POLICIES[name]
    tried = tuning.configurations(entry.scalars)
    assert 1 <= len(tried) <= tuning.MOST_CONFIGURATIONS
    for values in tried:
        entry.having(**values).make()


@pytest.mark.parametrize("n", [(10, 6), (51,), (2, 2, 2)])
def test_more_than_the_budget_is_refused(n: tuple[int, ...]) -> None:
    scalars = [Scalar(f"s{i}", tuple(map(float, range(size)))) for i, size in enumerate(n)]
    with pytest.raises(BadInput, match="at most 2 and 50"):
        tuning.configurations(scalars)


def test_the_grid_is_every_combination() -> None:
    tried = tuning.configurations([Scalar("a", (1.0, 2.0)), Scalar("b", (3.0, 4.0))])
    assert tried == [{"a": a, "b": b} for a in (1.0, 2.0) for b in (3.0, 4.0)]
    assert tuning.configurations([]) == [{}]


@settings(deadline=None)
@given(TRIALS)
def test_the_best_succeeds_most_and_of_those_costs_least(trials: list[Trial]) -> None:
    chosen = tuning.best(trials)
    for trial in trials:
        assert trial.n_successes <= chosen.n_successes
        if trial.n_successes == chosen.n_successes:
            assert trial.mean_realized_cost >= chosen.mean_realized_cost


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("name", registry.POLICIES)
def test_what_ships_is_the_best_of_its_own_ledger(name: str, profile: str) -> None:
    shipped = tuning.shipped(name, profile)
    if shipped is None:
        return
    assert (shipped.policy, shipped.profile) == (name, profile)
    assert shipped.values == tuning.best(shipped.trials).values
    scalars = registry.POLICIES[name].scalars
    assert [trial.values for trial in shipped.trials] == tuning.configurations(scalars)
    registry.tuned(name, profile).make()


def test_damaged_tuned_values_are_refused_by_name() -> None:
    with pytest.raises(BadInput, match=r"here\.json"):
        tuning.parse(b"{}", "here.json")


@settings(deadline=None)
@given(st.dictionaries(st.sampled_from(["tau", "min_gain"]), st.integers(0, 99).map(float)))
def test_a_policy_with_values_is_read_as_it_was_written(values: dict[str, float]) -> None:
    word = tuning.written("greedy", values) if values else "greedy"
    assert tuning.read_name(word) == ("greedy", values)


def test_a_policy_takes_the_values_of_its_name() -> None:
    entry = registry.tuned("greedy-threshold[at_least=0.35]", "paper")
    assert entry.make() == Greedy(0.35)


@pytest.mark.parametrize("word", ["greedy-threshold[tau=1]", "greedy[at_least=1]", "greedy[x]"])
def test_a_scalar_that_a_policy_does_not_have_is_refused(word: str) -> None:
    with pytest.raises(BadInput, match=r"no scalar|are written"):
        registry.tuned(word, "paper")
