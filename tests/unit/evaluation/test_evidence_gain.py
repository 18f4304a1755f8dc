"""What the switches are worth, on scenes by script: twins of which one stands wrongly."""

import math
from dataclasses import replace as replace_story

import numpy as np
import pytest
from msgspec.structs import replace
from scripted_table import parameters

from surefetch.belief.evidence import Seen
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import Answer, Answers
from surefetch.common.parameters import Parameters
from surefetch.evaluation.fitting import evidence_gain, fit
from surefetch.evaluation.fitting.evidence_switches import SWITCHES, TEMPERINGS, turned_on
from surefetch.evaluation.fitting.fit_evidence import AnswerCounts
from surefetch.evaluation.recordings.story import Heard, Story, log_score, total


def answers(membership: str, color: str = "supported") -> Answers:
    return Answers(
        color=Answer(label=color, scores=(0.0, 0.0, 0.0)),
        shape=None,
        marking=None,
        membership=Answer(label=membership, scores=(0.0, 0.0, 0.0)),
    )


def story(seed: int, asked: AskedRelation = "inside", looks: int = 2) -> Story:
    """The target inside and its twin outside, both read rightly from everywhere."""
    told = {1: ("MI", answers("inside")), 2: ("MO", answers("outside"))}
    heard = tuple(
        Heard(
            "center",
            (1, 2),
            tuple(Seen(f"{nth}-{i}", i, y, said) for i, (y, said) in told.items()),
            "1:inside",
        )
        for nth in range(looks)
    )
    counted = AnswerCounts()
    for _ in range(looks):
        counted.identity["color", "center", "match", "supported"] += 2
        counted.membership["center", "inside", "inside"] += 1
        counted.membership["center", "outside", "outside"] += 1
    counted.distractors[asked, "color", "outside", (True,)] += 1
    counts = fit.Counts()
    counts.first["tracked"] += 1
    counts.relation["inside"] += 1
    counts.new_tracks["right", "open", "appeared", 1] += 1
    return Story("ambiguous", seed, asked, False, heard, {"extended": counts}, counted)


def fit_off(stories: object) -> Parameters:
    return parameters("extended")


STORIES = [story(seed) for seed in range(40)]


def test_a_story_is_scored_by_the_truth_after_each_of_its_looks() -> None:
    off = parameters("extended")
    one, two, three = (log_score(story(0, looks=n), off) for n in (1, 2, 3))
    assert math.log(0.3) < one < math.log(0.5)
    after_the_last = [one, 2 * two - one, 3 * three - 2 * two]
    assert after_the_last == sorted(after_the_last)
    assert after_the_last[-1] == pytest.approx(math.log(0.45), abs=0.1)  # twins stay alike


def test_switches_replace_their_own_part_alone() -> None:
    off = parameters("extended")
    for name in SWITCHES:
        needed = {"attribute_evidence"} if name == "company" else set()
        without, on = turned_on(off, STORIES, needed), turned_on(off, STORIES, needed | {name})
        changed = {f for f in off.__struct_fields__ if getattr(on, f) != getattr(without, f)}
        assert changed == {name}
    assert turned_on(off, STORIES, ()) == turned_on(off, STORIES, {"company"}) == off


def test_the_prior_of_an_asked_relation_comes_from_scenes_that_ask_for_it() -> None:
    mixed = [*STORIES, *(story(seed, "any") for seed in range(10))]
    on = turned_on(parameters("extended"), mixed, {"asked_prior"})
    assert on.belief_priors("inside").relation["inside"] == pytest.approx(41 / 42)
    assert on.belief_priors("any").relation["inside"] == pytest.approx(11 / 12)
    assert on.belief_priors("outside").relation["inside"] == pytest.approx(1 / 2)
    assert on.belief_priors("any").birth == on.priors.birth


def test_the_prior_of_a_cover_state_is_drawn_to_that_of_all_where_few_begin_so() -> None:
    covered = replace_story(story(1), covered=True)
    asked_alike = turned_on(parameters("extended"), [*STORIES, covered], {"asked_prior"})
    on = turned_on(asked_alike, [*STORIES, covered], {"cover_prior"})
    expected = asked_alike.belief_priors("inside")
    few, none = (on.belief_priors(asked, covered=True) for asked in ("inside", "any"))
    assert few.tracked == pytest.approx((1 + 2 * expected.tracked) / 3)
    assert none.tracked == pytest.approx(asked_alike.belief_priors("any").tracked)
    assert on.belief_priors("inside").tracked == pytest.approx((40 + 2 * expected.tracked) / 42)
    assert sum((few.tracked, few.absent, few.unobserved)) == pytest.approx(1.0)


def test_the_fitted_tempering_is_the_best_of_its_grid() -> None:
    off = turned_on(parameters("extended"), STORIES, {"asked_prior", "attribute_evidence"})
    found = turned_on(off, STORIES, {"tempering"})
    scores = [
        sum(log_score(s, replace(off, tempering=gamma)) for s in STORIES) for gamma in TEMPERINGS
    ]
    assert found.tempering == TEMPERINGS[int(np.argmax(scores))]


def test_twins_are_told_apart_by_what_was_asked() -> None:
    found = evidence_gain.worth(STORIES, fit_off)
    assert found.n == len(STORIES)
    for name in ("asked_prior", "attribute_evidence"):
        assert found.alone[name].mean > 0.4
        assert (found.alone[name].better, found.alone[name].worse) == (len(STORIES), 0)
    assert found.all_on > found.none + 0.5
    text = evidence_gain.table(found)
    assert all(name in text for name in SWITCHES)


def test_a_half_is_never_scored_with_numbers_of_its_own() -> None:
    fitted_on: list[set[int]] = []

    def fit_half(stories: object) -> Parameters:
        assert isinstance(stories, list)
        fitted_on.append({s.seed % 2 for s in stories})
        return parameters("extended")

    scores = evidence_gain.crossed(STORIES, fit_half, frozenset())
    assert fitted_on == [{0}, {1}]
    assert len(scores) == len(STORIES)
    with pytest.raises(ValueError, match="odd"):
        evidence_gain.crossed(STORIES[:1], fit_half, frozenset())


def test_a_gain_is_the_paired_difference() -> None:
    one = {("visible", seed): float(seed) for seed in range(3)}
    other = {("visible", 0): 0.0, ("visible", 1): 0.0, ("visible", 2): 3.0}
    found = evidence_gain.gain(one, other)
    assert (found.mean, found.better, found.worse) == (0.0, 1, 1)
    assert found.standard_error == pytest.approx(1.0 / math.sqrt(3))


def test_counts_of_stories_add_up() -> None:
    assert total(STORIES, "extended").first["tracked"] == len(STORIES)
    assert not total([], "extended").first
