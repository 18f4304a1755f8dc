"""Parameter files: read back as written, and refused with the key that is wrong."""

import json
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from scripted_table import parameters

from surefetch.common.answer_tables import (
    ATTRIBUTES,
    AnswerTables,
    Company,
    Has,
    LabelCounts,
    attributes_in,
    named_key,
)
from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import ASKED
from surefetch.common.parameters import (
    BeliefPriors,
    BirthCounts,
    Parameters,
    parse_parameters,
    read_parameters,
    shipped_parameters,
    write_parameters,
)

PRIOR = BeliefPriors(
    relation={"inside": 0.9, "outside": 0.1}, absent=0.2, unobserved=0.3, tracked=0.5, birth=0.9
)


def with_switches() -> Parameters:
    row: dict[str, dict[Has, LabelCounts]] = {"center": {"match": (3, 0, 1), "mismatch": (0, 2, 0)}}
    tables = AnswerTables(
        identity={"color": row, "shape": row, "marking": {}},
        membership={"center": {"inside": (4, 0, 1)}},
        distractors={"inside": {"color shape": {"outside": (1, 2, 3, 4)}}},
    )
    return replace(
        parameters("extended"),
        asked_prior=dict.fromkeys(ASKED, PRIOR),
        attribute_evidence=tables,
        company=Company(distractors=tables.distractors, weight=0.5),
        tempering=0.25,
    )


def test_files_are_read_back_as_written(tmp_path: Path) -> None:
    for written in (parameters("paper"), with_switches()):
        write_parameters(tmp_path / "p.json", written)
        assert read_parameters(tmp_path / "p.json") == written


def test_every_switch_is_off_in_the_paper_profile_and_where_a_file_says_nothing() -> None:
    for off in (shipped_parameters("paper"), parameters("extended")):
        assert off.asked_prior is None
        assert off.attribute_evidence is None
        assert (off.cover_prior, off.births, off.company) == (None, None, None)
        assert off.tempering == 0.5
        assert off.belief_priors("inside") == off.priors


def test_a_named_set_has_one_spelling() -> None:
    assert named_key(("marking", "color")) == "color marking"
    assert attributes_in(" ".join(ATTRIBUTES)) == ATTRIBUTES
    assert attributes_in("") == ()
    with pytest.raises(ValueError, match="in that order"):
        attributes_in("marking color")


def broken(**changes: Any) -> bytes:
    """A file with all switches, and another value at a dotted key."""
    fields: dict[str, Any] = json.loads(_written())
    for key, value in changes.items():
        *way, last = key.split("__")
        place = fields
        for name in way:
            place = place[name]
        place[last] = value
    return json.dumps(fields).encode()


def _written() -> bytes:

    return msgspec.json.encode(with_switches())


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (broken(asked_prior={"inside": json.loads(_written())["asked_prior"]["inside"]}), "any"),
        (broken(tempering=-1.0), "tempering"),
        (broken(attribute_evidence__identity={}), "identity lacks color, marking, shape"),
        (broken(attribute_evidence__identity__size={}), "size"),
        (broken(attribute_evidence__membership__center={"under": [1, 2, 3]}), "under"),
        (broken(attribute_evidence__membership__center={"inside": [1, 2]}), "length 3"),
        (broken(attribute_evidence__distractors__any={"color": {"inside": [1]}}), "2 counts"),
        (broken(attribute_evidence__distractors__any={"shape color": {}}), "in that order"),
        (broken(attribute_evidence=None), "company needs attribute_evidence"),
        (broken(asked_prior__any__relation={"inside": 1.0}), "relation"),
    ],
)
def test_damaged_tables_are_refused_with_what_is_wrong(content: bytes, said: str) -> None:
    with pytest.raises(BadInput, match=said) as refused:
        parse_parameters(content, "own.json")
    assert "own.json" in str(refused.value)


def test_the_chance_that_a_target_appears_is_asked_by_look_and_is_none_where_it_is_off() -> None:
    counts = BirthCounts(with_target=(5, 2), without=(11, 4, 0), still_unseen=3)
    off = parameters("extended")
    on = replace(off, births={"right": {"open": counts}})
    assert on.p_appears("right") == pytest.approx(8 / 12)
    assert on.p_appears("right", covered=True) == on.p_appears("center") == 0.0
    assert off.p_appears("right") == 0.0
    assert off.commit_at_least == 0.0


def test_priors_by_cover_state_replace_those_by_asked_relation() -> None:
    other = replace(PRIOR, absent=0.6, unobserved=0.1, tracked=0.3)
    table = {"open": dict.fromkeys(ASKED, PRIOR), "covered": dict.fromkeys(ASKED, other)}
    on = replace(with_switches(), cover_prior=table)
    assert on.belief_priors("any") == PRIOR
    assert on.belief_priors("any", covered=True) == other
    assert with_switches().belief_priors("any", covered=True) == PRIOR
    with pytest.raises(BadInput, match="cover_prior lacks covered"):
        parse_parameters(msgspec.json.encode(replace(on, cover_prior={"open": table["open"]})), "f")
    with pytest.raises(BadInput, match="cover_prior.open must have"):
        gap = {"open": {"any": PRIOR}, "covered": table["covered"]}
        parse_parameters(msgspec.json.encode(replace(on, cover_prior=gap)), "f")


@given(st.integers(0, 9), st.integers(0, 9), st.tuples(*[st.integers(0, 9)] * 3))
def test_the_ratio_of_new_tracks_is_of_two_distributions(
    one: int, more: int, without: tuple[int, int, int]
) -> None:
    counts = BirthCounts(with_target=(one, more), without=without, still_unseen=0)
    of_clutter = [(n + 1) / (sum(without) + 3) for n in without]
    with_target = [counts.likelihood_ratio(n) * of_clutter[n] for n in range(3)]
    assert sum(with_target) == pytest.approx(1.0)
    assert with_target[0] == 0.0
    assert counts.likelihood_ratio(7) == counts.likelihood_ratio(2)
