"""Counting walks: every capture once, every transition once, priors by add-one smoothing."""

import pytest
from made_up_looks import look

from surefetch.common.parameters import BirthCounts
from surefetch.evaluation.fitting import fit
from surefetch.evaluation.fitting.fit_births import birth_table
from surefetch.evaluation.recordings.walk import Look

FIRST = look("center", {1: "UU", 2: "mismatch"}, new=(1, 2), target_track=1)
RIGHT = look("right", {1: "MI", 2: "mismatch"}, target_track=1)
HIGH = look("close_high", {1: "MI"}, y0={1: "MI", 2: "mismatch"}, target_track=1)
LAST = look("close_high", {1: "MI"}, y0={1: "MI", 2: "mismatch"}, target_track=1)
WALKS: dict[tuple[str, ...], list[Look]] = {
    (): [FIRST],
    ("right",): [FIRST, RIGHT],
    ("right", "close_high"): [FIRST, RIGHT, LAST],
    ("close_high",): [FIRST, HIGH],
    ("close_high", "right"): [FIRST, HIGH, RIGHT],
}
ALL = ("right", "close_high")


def test_every_capture_counts_once_with_the_class_of_the_truth() -> None:
    counts = fit.count(WALKS, ALL, "inside")
    assert counts.emission == {
        ("center", "target_inside", "UU"): 1,
        ("center", "distractor", "mismatch"): 1,
        ("right", "target_inside", "MI"): 1,
        ("right", "distractor", "mismatch"): 1,
        ("close_high", "target_inside", "MI"): 1,
    }


def test_a_pair_is_what_a_track_had_and_what_its_next_look_gave() -> None:
    counts = fit.count(WALKS, ALL, "inside")
    assert counts.paired["right", "UU", "target_inside", "MI"] == 1
    assert counts.paired["close_high", "UU", "target_inside", "MI"] == 1
    assert counts.paired["right", "MI", "target_inside", "MI"] == 1
    assert counts.paired["close_high", "MI", "target_inside", "MI"] == 1
    assert counts.paired["right", "mismatch", "distractor", "mismatch"] == 2
    assert counts.paired.total() == 6


def test_all_are_distractors_when_the_target_is_absent() -> None:
    first = look("center", {1: "MI", 2: "mismatch"}, new=(1, 2), relation=None)
    counts = fit.count({(): [first]}, (), None)
    assert {name for _, name, _ in counts.emission} == {"distractor"}
    assert counts.first == {"abs": 1}
    assert not counts.relation


def test_a_birth_is_a_success_when_the_target_is_among_the_new() -> None:
    first = look("center", {1: "mismatch"}, new=(1,))
    other = look("right", {2: "mismatch"}, new=(2,))
    found = look("close_high", {3: "MI"}, new=(3,), target_track=3)
    counts = fit.count({(): [first], ALL: [first, other, found]}, ALL, "inside")
    assert counts.first == {"unobs": 1}
    assert counts.births == {False: 1, True: 1}


def test_looks_without_new_tracks_count_and_a_target_taken_for_a_known_track_does_not() -> None:
    first = look("center", {1: "mismatch"}, new=(1,))
    nothing = look("right", {1: "mismatch"}, y0={1: "mismatch"})
    taken_for_1 = look("right", {1: "MI"}, target_track=1)
    found = look("close_high", {2: "MI", 3: "UU"}, new=(2, 3), target_track=2)
    walks = {
        (): [first],
        ("right",): [first, nothing],
        ("close_high",): [first, found],
        ("right again",): [first, taken_for_1],
        ("right", "close_high"): [first, nothing, found],
        ("close_high", "right"): [first, found, nothing],
    }
    counted = fit.count(walks, ("right", "close_high"), "inside").new_tracks
    assert counted == {
        ("right", "open", "stayed", 0): 1,
        ("close_high", "open", "appeared", 2): 2,
        ("right", "open", "known", 0): 1,
    }
    table = birth_table(counted)
    assert table["right"]["open"] == BirthCounts(
        with_target=(0, 0), without=(2, 0, 0), still_unseen=1
    )
    assert table["close_high"]["open"].with_target == (0, 2)


def test_the_papers_constants_come_out_of_its_counts() -> None:
    counts = fit.Counts()
    counts.first.update({"abs": 4, "unobs": 8, "tracked": 12})
    counts.relation.update({"inside": 8, "outside": 12})
    counts.births.update({True: 8, False: 4})
    assert fit.priors(counts) == pytest.approx(
        {"inside": 9 / 22, "abs": 5 / 27, "unobs": 1 / 3, "beta_birth": 9 / 14}
    )


def test_counts_of_two_scenes_add_up() -> None:
    one = fit.count(WALKS, ALL, "inside")
    both = one + one
    assert both.emission["center", "target_inside", "UU"] == 2
    assert both.first == {"tracked": 2}


def test_tables_hold_seven_counts_and_only_what_was_seen() -> None:
    counts = fit.count(WALKS, ALL, "inside")
    emissions, paired = fit.emission_table(counts), fit.paired_table(counts)
    assert emissions["center"] == {
        "target_inside": (0, 0, 0, 0, 0, 0, 1),
        "distractor": (0, 0, 0, 1, 0, 0, 0),
    }
    assert paired["right"]["UU"] == {"target_inside": (1, 0, 0, 0, 0, 0, 0)}
    assert "target_outside" not in emissions["right"]
