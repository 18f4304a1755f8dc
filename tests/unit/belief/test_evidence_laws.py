"""Laws of the belief under answers kept apart, whatever the tables."""

from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from surefetch.belief.attribute_evidence import AttributeEvidence, distractor_patterns
from surefetch.belief.evidence import NOTHING, CategoryEvidence, Evidence, Seen
from surefetch.belief.filter import FLOOR, Memory, Model, Step, step
from surefetch.common.answer_tables import (
    ATTRIBUTES,
    AnswerTables,
    Attribute,
    Company,
    DistractorTable,
)
from surefetch.common.emission import Emission
from surefetch.common.hypotheses import (
    ASKED,
    CLASSES,
    IDENTITY_LABELS,
    MEMBERSHIP_LABELS,
    OBSERVATIONS,
    RELATIONS,
)
from surefetch.common.messages import Answer, Answers
from surefetch.common.observations import observation_of
from surefetch.common.parameters import PRINTED

CONDITIONS = ("center", "after_removal", "right")
conditions = st.sampled_from((*CONDITIONS, "never seen"))
few = st.integers(0, 40)
three = st.tuples(few, few, few)
asked_relations = st.sampled_from(ASKED)
named_sets: st.SearchStrategy[tuple[Attribute, ...]] = st.sets(st.sampled_from(ATTRIBUTES)).map(
    lambda chosen: tuple(u for u in ATTRIBUTES if u in chosen)
)
temperings = st.sampled_from((0.0, 0.25, 0.5, 1.0))
Labels = tuple[str, str, str, str]
labels = st.tuples(
    *(st.sampled_from(IDENTITY_LABELS) for _ in ATTRIBUTES), st.sampled_from(MEMBERSHIP_LABELS)
)
Look = tuple[str, dict[int, Labels]]


@st.composite
def sensible_rows(draw: st.DrawFn) -> dict[str, tuple[int, int, int]]:
    """A question that is not answered wrongly more often than rightly."""
    right, wrong = sorted(draw(st.tuples(few, few)), reverse=True)
    right_no, wrong_no = sorted(draw(st.tuples(few, few)), reverse=True)
    return {
        "match": (right, wrong, draw(few)),
        "mismatch": (wrong_no, right_no, draw(few)),
    }


by_condition = st.dictionaries(st.sampled_from(CONDITIONS), sensible_rows())
rows_of = st.fixed_dictionaries({r: st.tuples(*[few] * 8) for r in RELATIONS})
tables = st.builds(
    AnswerTables,
    identity=st.fixed_dictionaries({u: by_condition for u in ATTRIBUTES}),
    membership=st.dictionaries(
        st.sampled_from(CONDITIONS), st.fixed_dictionaries({r: three for r in RELATIONS})
    ),
    distractors=st.dictionaries(
        asked_relations, st.fixed_dictionaries({" ".join(ATTRIBUTES): rows_of})
    ),
)
RELIABLE = AnswerTables(
    identity={u: {"center": {"match": (80, 2, 18), "mismatch": (2, 80, 18)}} for u in ATTRIBUTES},
    membership={"center": {"inside": (90, 1, 9), "outside": (1, 90, 9)}},
    distractors={},
)


def answers(told: Labels, named: tuple[str, ...] = ATTRIBUTES) -> Answers:
    of = {
        u: Answer(label=label, scores=(0.0, 0.0, 0.0))
        for u, label in zip(ATTRIBUTES, told[:3], strict=True)
    }
    return Answers(
        color=of["color"] if "color" in named else None,
        shape=of["shape"] if "shape" in named else None,
        marking=of["marking"] if "marking" in named else None,
        membership=Answer(label=told[3], scores=(0.0, 0.0, 0.0)),
    )


def seen(nth: int, track: int, told: Labels, named: tuple[str, ...]) -> Seen:
    heard = answers(told, named)
    return Seen(f"{nth}-{track}", track, observation_of(heard), heard)


@st.composite
def episodes(draw: st.DrawFn, births: bool = True) -> list[tuple[int, Look]]:
    """Looks, each with the number of tracks by then."""
    n_tracks, looks = draw(st.integers(1, 3)), []
    for _ in range(draw(st.integers(1, 4))):
        n_tracks += draw(st.integers(0, 2)) if births else 0
        told = draw(st.dictionaries(st.integers(1, n_tracks), labels))
        looks.append((n_tracks, (draw(conditions), told)))
    return looks


def fold(
    looks: list[tuple[int, Look]],
    model: Model,
    named: tuple[str, ...] = ATTRIBUTES,
    shift: int = 0,
) -> list[Step]:
    memory, steps = Memory(), []
    for nth, (n_tracks, (q, told)) in enumerate(looks):
        heard = [seen(nth, shift + i, answer, named) for i, answer in told.items()]
        tracks = range(shift + 1, shift + n_tracks + 1)
        steps.append(step(memory, tracks, heard, q, model))
        memory = steps[-1].memory
    return steps


def model_of(table: AnswerTables, asked: str, tempering: float = 0.5) -> Model:
    assert asked in ASKED
    return Model(AttributeEvidence(table, asked), PRINTED, tempering)


@settings(deadline=None)
@given(episodes(), tables, asked_relations, named_sets, temperings)
def test_belief_and_patterns_stay_normalised(
    looks: list[tuple[int, Look]],
    table: AnswerTables,
    asked: str,
    named: tuple[str, ...],
    tempering: float,
) -> None:
    for done in fold(looks, model_of(table, asked, tempering), named):
        assert sum(done.belief.named().values()) == pytest.approx(1.0, abs=1e-12)
        assert set(done.memory.known) == set(done.memory.n_observations)
        for known in done.memory.known.values():
            assert sum(known) == pytest.approx(1.0, abs=1e-12)
            assert min(known) >= 0.0


@settings(deadline=None)
@given(tables, asked_relations, named_sets)
def test_a_distractor_never_has_all_that_is_asked(
    table: AnswerTables, asked: str, named: tuple[Attribute, ...]
) -> None:
    assert asked in ASKED
    chances = distractor_patterns(table, asked, named)
    assert chances.sum() == pytest.approx(1.0)
    allowed = [r for r, relation in enumerate(RELATIONS) if asked in ("any", relation)]
    if named or asked != "any":
        assert not chances[0, allowed].any()
    else:
        assert (chances[0] > 0.0).all()


@settings(deadline=None)
@given(episodes(), tables, asked_relations)
def test_an_observation_with_a_known_id_teaches_nothing(
    looks: list[tuple[int, Look]], table: AnswerTables, asked: str
) -> None:
    model = model_of(table, asked)
    done = fold(looks, model)[-1]
    heard = answers(("supported", "supported", "supported", "inside"))
    again = [Seen(id_, 1, "MI", heard) for id_ in done.memory.counted_ids]
    repeated = step(done.memory, done.belief.tracks, again, "center", model)
    assert repeated.memory.known == done.memory.known
    assert repeated.belief.named() == pytest.approx(done.belief.named(), rel=1e-12)


@settings(deadline=None)
@given(episodes(), tables, asked_relations, st.integers(1, 50))
def test_renumbering_tracks_renumbers_belief_and_patterns(
    looks: list[tuple[int, Look]], table: AnswerTables, asked: str, shift: int
) -> None:
    model = model_of(table, asked)
    plain, moved = fold(looks, model)[-1], fold(looks, model, shift=shift)[-1]
    assert np.array_equal(plain.belief.p_tracked, moved.belief.p_tracked)
    assert {i + shift: known for i, known in plain.memory.known.items()} == moved.memory.known


@settings(deadline=None)
@given(episodes(births=False), tables, asked_relations)
def test_the_order_of_looks_does_not_matter_without_tempering_and_births(
    looks: list[tuple[int, Look]], table: AnswerTables, asked: str
) -> None:
    model = model_of(table, asked, tempering=0.0)
    one, *others = (fold(list(order), model)[-1] for order in permutations(looks))
    for other in others:
        assert other.belief.named() == pytest.approx(one.belief.named(), rel=1e-9, abs=1e-300)


@settings(deadline=None, max_examples=200)
@given(episodes(), tables, asked_relations, temperings, st.data())
def test_to_contradict_an_attribute_instead_never_makes_the_track_likelier(
    looks: list[tuple[int, Look]],
    table: AnswerTables,
    asked: str,
    tempering: float,
    data: st.DataObject,
) -> None:
    told = [(nth, i) for nth, (_, (_, told)) in enumerate(looks) for i in told]
    if not told:
        return
    nth, track = data.draw(st.sampled_from(told))
    attribute = data.draw(st.integers(0, 2))

    def target_mass(label: str) -> float:
        n_tracks, (q, by_track) = looks[nth]
        changed = list(by_track[track])
        changed[attribute] = label
        heard = {**by_track, track: tuple(changed)}
        now = [*looks[:nth], (n_tracks, (q, heard)), *looks[nth + 1 :]]
        belief = fold(now, model_of(table, asked, tempering))[-1].belief  # type: ignore[arg-type]
        return float(belief.p_tracked[belief.tracks.index(track)].sum())

    assert target_mass("contradicted") <= target_mass("supported") * (1 + 1e-9)


@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("membership", MEMBERSHIP_LABELS)
def test_no_look_that_contradicts_an_attribute_makes_the_track_likelier(
    asked: str, membership: str
) -> None:
    for color, shape, marking in product(IDENTITY_LABELS, repeat=3):
        if "contradicted" in (color, shape, marking):
            told: Labels = (color, shape, marking, membership)
            (done,) = fold([(1, ("center", {1: told}))], model_of(RELIABLE, asked))
            assert done.belief.p_tracked.sum() < done.prior.p_tracked.sum()


@settings(deadline=None)
@given(episodes(), tables, asked_relations, st.sampled_from(IDENTITY_LABELS))
def test_what_is_not_asked_says_nothing(
    looks: list[tuple[int, Look]], table: AnswerTables, asked: str, label: str
) -> None:
    model, named = model_of(table, asked), ("color", "shape")
    other = [
        (n, (q, {i: (one[0], one[1], label, one[3]) for i, one in told.items()}))
        for n, (q, told) in looks
    ]
    one, same = fold(looks, model, named)[-1], fold(other, model, named)[-1]
    assert one.belief.named() == same.belief.named()


@settings(deadline=None)
@given(episodes(), tables, asked_relations, temperings)
def test_where_tables_without_a_target_are_like_the_others_their_company_says_nothing(
    looks: list[tuple[int, Look]], table: AnswerTables, asked: str, tempering: float
) -> None:
    assert asked in ASKED
    twice = replace(table, distractors=summed(table.distractors, table.distractors))
    alike = Company(distractors=table.distractors, weight=1.0)
    model = model_of(twice, asked, tempering)
    evidence = AttributeEvidence(twice, asked, alike)
    without = fold(looks, model)[-1].belief
    with_it = fold(looks, Model(evidence, PRINTED, tempering))[-1].belief
    assert with_it.p_abs / with_it.p_unobs == pytest.approx(without.p_abs / without.p_unobs)


companies = st.builds(
    lambda table, weight: Company(distractors=table.distractors, weight=weight),
    tables,
    st.floats(0.0, 1.0),
)


@settings(deadline=None)
@given(episodes(births=False), tables, companies, asked_relations)
def test_the_order_of_looks_does_not_matter_with_company_either(
    looks: list[tuple[int, Look]], table: AnswerTables, company: Company, asked: str
) -> None:
    assert asked in ASKED
    model = Model(AttributeEvidence(table, asked, company), PRINTED, tempering=0.0)
    one, *others = (fold(list(order), model)[-1] for order in permutations(looks))
    for other in others:
        assert other.belief.named() == pytest.approx(one.belief.named(), rel=1e-9, abs=1e-300)


NEAR_MISSES: DistractorTable = {"inside": {" ".join(ATTRIBUTES): {"inside": (0, 99, 0, *[0] * 5)}}}
"""All tracks have the colour and the shape that are asked, and another marking."""
UNLIKE: DistractorTable = {"inside": {" ".join(ATTRIBUTES): {"inside": (*[0] * 7, 99)}}}


@pytest.mark.parametrize("weight", [0.0, 0.5, 1.0])
def test_a_near_miss_speaks_for_absence_where_tables_without_a_target_hold_more_of_them(
    weight: float,
) -> None:
    unread: Labels = ("supported", "supported", "unobservable", "inside")
    unlike: Labels = ("contradicted", "contradicted", "contradicted", "inside")
    table = replace(RELIABLE, distractors=summed(NEAR_MISSES, UNLIKE))
    company = Company(distractors=NEAR_MISSES, weight=weight)
    model = Model(AttributeEvidence(table, "inside", company), PRINTED, 0.0)
    odds = []
    for told in (unread, unlike):
        (done,) = fold([(1, ("center", {1: told}))], model)
        odds.append(done.belief.p_abs / done.belief.p_unobs * PRINTED.unobserved / PRINTED.absent)
    if weight == 0.0:
        assert odds == pytest.approx([1.0, 1.0])
    else:
        assert odds[0] > 2.0
        assert odds[1] < 0.5


def summed(one: DistractorTable, other: DistractorTable) -> DistractorTable:
    """Of two tables with the same keys."""
    return {
        asked: {
            key: {
                r: tuple(map(sum, zip(row, other[asked][key][r], strict=True)))
                for r, row in by_relation.items()
            }
            for key, by_relation in by_named.items()
        }
        for asked, by_named in one.items()
    }


@pytest.mark.parametrize("asked", ["inside", "outside"])
@pytest.mark.parametrize("tempering", [0.0, 0.5])
def test_a_twin_in_the_wrong_relation_ends_below_the_right_one(
    asked: str, tempering: float
) -> None:
    both = ("supported", "supported", "supported")
    look: Look = ("center", {1: (*both, "inside"), 2: (*both, "outside")})
    belief = fold([(2, look)] * 2, model_of(RELIABLE, asked, tempering))[-1].belief.named()
    right, wrong = ("1:inside", "2:outside") if asked == "inside" else ("2:outside", "1:inside")
    assert belief[right] > 0.9
    assert belief[wrong] < 0.05


def test_what_was_read_once_is_not_doubted_anew_from_where_it_cannot_be_read() -> None:
    told: Labels = ("supported", "supported", "contradicted", "inside")
    unread: Labels = ("supported", "supported", "unobservable", "inside")
    steps = fold(
        [(1, ("center", {1: told})), *[(1, ("center", {1: unread}))] * 3],
        model_of(RELIABLE, "inside", 0.0),
    )
    masses = [done.belief.named()["1:inside"] for done in steps]
    assert masses[0] < 0.85 * steps[0].prior.named()["1:inside"]
    assert max(masses) < 1.1 * masses[0]


observed = st.lists(
    st.lists(st.tuples(st.integers(1, 3), st.sampled_from(OBSERVATIONS)), max_size=4),
    min_size=1,
    max_size=4,
)
counts = st.dictionaries(
    st.sampled_from(CONDITIONS),
    st.dictionaries(st.sampled_from(CLASSES), st.lists(few, min_size=7, max_size=7)),
)


@settings(deadline=None)
@given(observed, counts)
def test_with_every_switch_off_the_product_is_the_papers_bit_for_bit(
    looks: list[list[tuple[int, str]]], table: dict[str, dict[str, list[int]]]
) -> None:
    evidence: Evidence = CategoryEvidence(Emission(table))
    E = Emission(table).likelihood("center")
    memory, n = Memory(), dict.fromkeys((1, 2, 3), 0)
    for nth, heard in enumerate(looks):
        told = [Seen(f"{nth}-{k}", i, y) for k, (i, y) in enumerate(heard)]
        done = step(memory, (1, 2, 3), told, "center", Model(evidence, PRINTED))
        p = np.maximum(done.prior.p_tracked, FLOOR)
        for i, y in dict(reversed(heard)).items():  # the first of each track counts
            n[i] += 1
            ratio = E[:-1] / E[-1]
            p[i - 1] *= ratio[:, OBSERVATIONS.index(y)] ** (n[i] ** -0.5)
        total = p.sum() + done.prior.p_unobs + done.prior.p_abs
        assert np.array_equal(done.belief.p_tracked, p / total)
        assert done.belief.p_unobs == done.prior.p_unobs / total
        memory = done.memory
    assert all(known == NOTHING for known in memory.known.values())
