"""Which states and sequences a recording holds."""

import pytest

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.evaluation.recordings import recording, splits

CELL = simulated_cell()


@pytest.mark.parametrize(
    ("covered", "n_states", "n_paths", "n_with_covered_views"), [(False, 3, 5, 5), (True, 6, 6, 30)]
)
def test_a_scene_has_the_states_and_sequences_of_its_cover(
    covered: bool, n_states: int, n_paths: int, n_with_covered_views: int
) -> None:
    assert len(recording.states(covered, CELL)) == n_states
    assert len(recording.paths(covered, CELL)) == n_paths
    more = recording.paths(covered, CELL, views_while_covered=True)
    assert len(more) == n_with_covered_views


def test_the_cover_is_lifted_once() -> None:
    covers = [state.cover for state in recording.states(True, CELL)]
    assert covers == ["closed"] * 3 + ["open"] * 3


def test_under_the_base_rules_nothing_is_viewed_from_elsewhere_while_a_cover_is_on() -> None:
    assert recording.paths(True, CELL)[1] == ("remove_cover",)
    assert all(path[0] == "remove_cover" for path in recording.paths(True, CELL) if path)


def test_no_action_comes_twice_in_a_sequence() -> None:
    for path in recording.paths(True, CELL, views_while_covered=True):
        assert len(set(path)) == len(path)


def test_looking_at_everything_opens_the_cover_first() -> None:
    assert recording.exhaustive_path(True, CELL) == ("remove_cover", "right", "close_high")
    assert recording.exhaustive_path(False, CELL) == ("right", "close_high")


def test_the_look_after_a_removal_is_a_condition_of_its_own() -> None:
    assert recording.condition_after((), CELL) == "center"
    assert recording.condition_after(("remove_cover",), CELL) == "after_removal"
    assert recording.condition_after(("remove_cover", "right"), CELL) == "right"


def test_seeds_are_named_by_split_or_by_range() -> None:
    assert splits.seeds_of("development", 3, None) == range(100_000, 100_003)
    assert splits.seeds_of(None, None, "5:9") == range(5, 9)


@pytest.mark.parametrize(
    ("split", "episodes", "seeds"),
    [
        (None, None, None),
        ("development", 3, "1:2"),
        ("develop", 3, None),
        ("development", 0, None),
        ("development", None, None),
        (None, None, "9:5"),
        (None, None, "a:b"),
        (None, None, "1:2:3"),
        (None, None, "-1:2"),
    ],
)
def test_badly_named_seeds_are_refused(
    split: str | None, episodes: int | None, seeds: str | None
) -> None:
    with pytest.raises(BadInput):
        splits.seeds_of(split, episodes, seeds)


@pytest.mark.parametrize("seed", [99_999, 200_000, 7])
def test_scenes_of_another_split_are_refused_for_fitting(seed: int) -> None:
    with pytest.raises(BadInput, match="development scenes only"):
        splits.require("development", [100_000, seed], "study fit")


def test_an_unknown_family_is_refused_with_the_list_of_them() -> None:
    assert splits.families_of(None) == splits.FAMILIES
    with pytest.raises(BadInput, match="ambiguous"):
        splits.families_of("visible,hidden")
