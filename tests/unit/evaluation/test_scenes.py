"""Plans keep the families' rules, sentences are read back, layouts stand where they should."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.instruction import parse
from surefetch.common.messages import Target, Vocabulary
from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.scenes import appearance, rejection, sentence
from surefetch.evaluation.scenes import candidate as scenes
from surefetch.evaluation.scenes import table as layout_table
from surefetch.evaluation.scenes.candidate import Candidate
from surefetch.evaluation.scenes.draws import MARKINGS, SHAPES
from surefetch.evaluation.scenes.families import OTHERS
from surefetch.evaluation.scenes.plan import ATTRIBUTES, Plan

CELL = simulated_cell()
VOCABULARY = Vocabulary(
    backend="test",
    open=False,
    nouns=sentence.NOUNS,
    colors=tuple(appearance.COLORS),
    shapes=SHAPES,
    markings=MARKINGS,
    containers=tuple(sentence.CONTAINER_WORDS.values()),
)
SEEDS = range(400)

families = st.sampled_from(FAMILIES)
seeds = st.integers(0, 2**63 - 1)


@st.composite
def targets(draw: st.DrawFn) -> Target:
    dropped = draw(st.sampled_from((None, *ATTRIBUTES)))
    shape = None if dropped == "shape" else draw(st.sampled_from(SHAPES))
    asked: tuple[AskedRelation, ...] = ("inside", "outside", "any")
    relation = draw(st.sampled_from(asked))
    words = st.sampled_from(tuple(sentence.CONTAINER_WORDS.values()))
    return Target(
        noun=shape or draw(st.sampled_from(sentence.NOUNS)),
        color=None if dropped == "color" else draw(st.sampled_from(tuple(appearance.COLORS))),
        shape=shape,
        marking=None if dropped == "marking" else draw(st.sampled_from(MARKINGS)),
        relation=relation,
        container="box" if relation == "any" else draw(words),
    )


def first_layout(plan: Plan, seed: int) -> Candidate:
    for attempt in range(100):
        try:
            return scenes.draw(plan, seed, attempt, CELL)
        except layout_table.NoRoom:
            continue
    raise AssertionError(f"nothing of {plan} could be laid out")


@given(targets(), st.integers(0, len(sentence.TEMPLATES) - 1), st.integers(0, 2))
@settings(deadline=None)
def test_every_sentence_is_read_back_as_its_target(
    target: Target, template: int, synonym: int
) -> None:
    assert parse(sentence.say(target, template, synonym), VOCABULARY) == target


def test_there_are_twelve_templates_and_all_say_something_else() -> None:
    target = Target(noun="cube", color="red", shape="cube", marking="dot", relation="inside")
    said = {sentence.say(target, k, 0) for k in range(len(sentence.TEMPLATES))}
    assert len(said) == 12


@given(families, seeds)
@settings(deadline=None)
def test_the_same_address_gives_the_same_plan(family: str, seed: int) -> None:
    assert scenes.plan_of(family, seed) == scenes.plan_of(family, seed)


@given(families, seeds)
@settings(deadline=None)
def test_a_plan_holds_as_many_bodies_as_its_family_may(family: str, seed: int) -> None:
    plan = scenes.plan_of(family, seed)
    targets = [part for part in plan.parts if part.role == "target"]
    low, high = OTHERS[family]
    assert low <= len(plan.parts) - len(targets) <= high
    assert len(targets) == (family != "absent")
    assert all(part.relation == plan.relation for part in targets)


@given(families, seeds)
@settings(deadline=None)
def test_what_is_named_picks_out_the_target_and_nothing_else(family: str, seed: int) -> None:
    plan = scenes.plan_of(family, seed)
    asked = plan.relation_asked
    fitting = [
        part.role
        for part in plan.parts
        if plan.matches(part.attributes) and asked in ("any", part.relation)
    ]
    assert fitting == ([] if family == "absent" else ["target"])
    assert len(plan.named) in (2, 3)


@given(families, seeds)
@settings(deadline=None)
def test_near_misses_share_two_attributes_and_fillers_one_at_most(family: str, seed: int) -> None:
    plan = scenes.plan_of(family, seed)
    for part in plan.parts:
        shared = part.attributes.shared(plan.asked)
        if part.role in ("target", "twin"):
            assert shared == 3
        elif part.role == "near miss":
            assert shared == 2
        else:
            assert shared <= 1


def share(family: str, holds: str) -> float:
    plans = [scenes.plan_of(family, seed) for seed in SEEDS]
    return float(np.mean([RATES[holds](plan) for plan in plans]))


RATES: dict[str, Callable[[Plan], bool]] = {
    "covered": lambda plan: plan.covered,
    "inside": lambda plan: plan.relation == "inside",
    "relation named": lambda plan: plan.relation_asked != "any",
    "all named": lambda plan: len(plan.named) == 3,
    "right": lambda plan: plan.stratum == "right",
    "close_high": lambda plan: plan.stratum == "close_high",
    "twin": lambda plan: any(part.role == "twin" for part in plan.parts),
    "screen": lambda plan: plan.empty_screen,
}


@pytest.mark.parametrize(
    ("family", "holds", "rate"),
    [
        ("visible", "covered", 0.15),
        ("visible", "inside", 0.25),
        ("visible", "relation named", 0.40),
        ("partial", "covered", 0.15),
        ("partial", "relation named", 0.30),
        ("partial", "right", 0.45),
        ("partial", "close_high", 0.30),
        ("covered", "covered", 1.0),
        ("covered", "twin", 0.50),
        ("ambiguous", "inside", 0.50),
        ("ambiguous", "covered", 0.25),
        ("ambiguous", "twin", 1.0),
        ("absent", "covered", 0.40),
        ("absent", "relation named", 0.70),
        ("absent", "twin", 0.21),
        ("absent", "screen", 0.50),
        ("absent", "all named", 0.70),
    ],
)
def test_plans_come_at_the_families_rates(family: str, holds: str, rate: float) -> None:
    """Within four standard errors over 400 seeds."""
    error = 4.0 * np.sqrt(max(rate * (1.0 - rate), 1e-9) / len(SEEDS))
    assert share(family, holds) == pytest.approx(rate, abs=error)


def test_one_distractor_in_ten_is_too_wide_for_the_hand() -> None:
    parts = [p for f in FAMILIES for s in SEEDS for p in scenes.plan_of(f, s).parts]
    others = [part for part in parts if part.role != "target"]
    assert np.mean([part.role == "wide" for part in others]) == pytest.approx(0.1, abs=0.02)


@pytest.mark.parametrize("family", FAMILIES)
def test_bodies_stand_on_their_side_of_the_wall_and_apart(family: str) -> None:
    for seed in range(6):
        candidate = first_layout(scenes.plan_of(family, seed), seed)
        assert rejection.boundary(candidate) is None
        container = candidate.scene.container
        assert container is not None
        assert candidate.plan.asked.color not in ("grey", "brown")
        for part, body in zip(candidate.plan.parts, candidate.scene.bodies, strict=True):
            assert rejection.relation_of(body, container) == part.relation
            assert rejection.too_wide(body) == (part.role == "wide")
            assert 0.025 <= body.size_m[2] <= 0.100
            assert 0.03 <= body.mass_kg <= 0.40


@pytest.mark.parametrize("family", FAMILIES)
def test_a_seed_draws_the_same_scene_again_and_other_attempts_others(family: str) -> None:
    plan = scenes.plan_of(family, 11)
    first = first_layout(plan, 11)
    assert first_layout(plan, 11) == first
    assert first_layout(scenes.plan_of(family, 12), 12).scene != first.scene


def test_an_unknown_family_is_refused_with_the_list_of_them() -> None:
    with pytest.raises(BadInput, match="ambiguous"):
        scenes.plan_of("hidden", 1)
