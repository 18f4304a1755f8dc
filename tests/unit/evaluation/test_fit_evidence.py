"""Answers counted by what the body under them is, and tracks by what they have."""

import msgspec
from made_up_looks import look

from surefetch.common.messages import Answer, Answers
from surefetch.evaluation.fitting import fit_evidence
from surefetch.evaluation.fitting.fit_evidence import AnswerCounts
from surefetch.evaluation.recordings.recording import BodyMatch, RecordingTruth
from surefetch.evaluation.recordings.walk import Look

TRUTH = RecordingTruth(
    format=1,
    family="covered",
    seed=100_000,
    target="target",
    relation="inside",
    graspable=("target",),
    matches={
        "target": BodyMatch(color=True, shape=True, marking=None, relation="inside"),
        "other": BodyMatch(color=False, shape=True, marking=None, relation="outside"),
    },
    shots=(),
)


def answers(color: str, shape: str, membership: str) -> Answers:
    def answer(label: str) -> Answer:
        return Answer(label=label, scores=(0.0, 0.0, 0.0))

    return Answers(
        color=answer(color), shape=answer(shape), marking=None, membership=answer(membership)
    )


def looked(q: str) -> Look:
    return look(
        q,
        {1: "MI", 2: "mismatch"},
        target_track=1,
        answers={
            f"{q}-1": answers("supported", "unobservable", "inside"),
            f"{q}-2": answers("contradicted", "supported", "unknown"),
        },
    )


def test_each_answer_counts_by_whether_the_body_has_what_was_asked() -> None:
    counts = fit_evidence.count([looked("center")], TRUTH, "inside")
    assert counts.identity == {
        ("color", "center", "match", "supported"): 1,
        ("shape", "center", "match", "unobservable"): 1,
        ("color", "center", "mismatch", "contradicted"): 1,
        ("shape", "center", "match", "supported"): 1,
    }
    assert counts.membership == {
        ("center", "inside", "inside"): 1,
        ("center", "outside", "unknown"): 1,
    }


def test_each_track_that_is_not_the_targets_counts_once_however_often_it_is_seen() -> None:
    counts = fit_evidence.count([looked("center"), looked("right")], TRUTH, "inside")
    assert counts.distractors == {("inside", "color shape", "outside", (False, True)): 1}
    assert counts.identity["color", "right", "match", "supported"] == 1


def test_answers_over_no_body_are_left_out() -> None:
    seen = looked("center")
    seen.bodies[2] = None
    counts = fit_evidence.count([seen], TRUTH, "inside")
    assert not counts.distractors
    assert counts.membership == {("center", "inside", "inside"): 1}


def test_tables_hold_the_counts_in_the_order_of_labels_and_patterns() -> None:
    tables = fit_evidence.tables(fit_evidence.count([looked("center")], TRUTH, "inside"))
    assert tables.identity["color"] == {"center": {"match": (1, 0, 0), "mismatch": (0, 1, 0)}}
    assert tables.identity["marking"] == {}
    assert tables.membership == {"center": {"inside": (1, 0, 0), "outside": (0, 0, 1)}}
    assert tables.distractors["inside"] == {
        "color shape": {"inside": (0, 0, 0, 0), "outside": (0, 0, 1, 0)}
    }
    assert tables.distractors["any"] == {}


def test_what_stands_on_tables_without_a_target_is_counted_apart_as_well() -> None:
    empty_table = msgspec.structs.replace(TRUTH, target=None, relation=None)
    without = fit_evidence.count([looked("center")], empty_table, "inside")
    both = without + fit_evidence.count([looked("center")], TRUTH, "inside")
    assert without.company == without.distractors == both.company
    company, tables = fit_evidence.company(both, 0.5), fit_evidence.tables(both)
    assert company.distractors["inside"]["color shape"]["outside"] == (0, 0, 1, 0)
    assert tables.distractors["inside"]["color shape"]["outside"] == (0, 0, 2, 0)


def test_counts_of_two_scenes_add_up_and_of_none_make_empty_tables() -> None:
    one = fit_evidence.count([looked("center")], TRUTH, "inside")
    assert (one + one).membership["center", "inside", "inside"] == 2
    empty = fit_evidence.tables(AnswerCounts())
    assert empty.membership == {}
