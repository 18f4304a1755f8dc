"""Accepted scenes show what their family asks, rest, and come out the same again."""

from functools import cache

import pytest

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.scenes import generate as generator
from surefetch.evaluation.scenes import rejection_sight
from surefetch.evaluation.scenes.candidate import plan_of
from surefetch.evaluation.scenes.generate import GeneratedScene, GeneratorError, generate
from surefetch.evaluation.scenes.rejection_sight import readable, unreadable
from surefetch.evaluation.scenes.truth import SceneTruth
from surefetch.executor.simulation.pybullet_world import PybulletWorld

SEEDS = (1, 2, 3)


@cache
def scene(family: str, seed: int) -> GeneratedScene:
    return generate(family, seed)


def truths(family: str) -> list[SceneTruth]:
    return [scene(family, seed).truth for seed in SEEDS]


@pytest.mark.parametrize("family", FAMILIES)
def test_a_scene_stays_where_it_was_put(family: str) -> None:
    with PybulletWorld(scene(family, 1).scene, shadows=False) as world:
        assert world.deepest_overlap_m() <= generator.OVERLAP_M
        assert world.settle() == scene(family, 1).truth.evidence["shift_m"]
        assert world.fastest_m_s() <= generator.SPEED_M_S


def test_the_same_address_gives_the_same_scene() -> None:
    again = generate("partial", 2)
    assert again.scene == scene("partial", 2).scene
    assert again.truth == scene("partial", 2).truth
    assert again.sentence == scene("partial", 2).sentence


def test_the_first_view_reads_a_visible_target() -> None:
    for truth in truths("visible"):
        assert truth.target is not None
        seen = [s for s in truth.sightings if s.body == truth.target and s.view == "center"]
        first = next(s for s in seen if s.cover != "open")
        assert first.share >= 0.85
        assert readable(first, marking=True)


def test_a_partial_target_is_read_from_its_stratums_views_alone() -> None:
    for truth in truths("partial"):
        assert truth.target is not None
        seen = [s for s in truth.sightings if s.body == truth.target and s.cover != "closed"]
        assert {s.view for s in seen if readable(s, marking=True)} == rejection_sight.STRATA[
            truth.stratum
        ]
        first = next(s for s in seen if s.view == "center")
        assert 0.45 <= 1.0 - first.share <= 0.95
        assert unreadable(first)


def test_a_covered_target_is_out_of_sight_until_the_lid_is_off() -> None:
    for truth in truths("covered"):
        assert truth.target is not None
        closed = [truth.sighting(truth.target, v, "closed") for v in rejection_sight.VIEWS]
        assert all(one.share == 0.0 for one in closed)
        assert readable(truth.sighting(truth.target, "center", "open"), marking=True)


def test_ambiguous_scenes_hold_one_twin_on_the_other_side() -> None:
    for truth in truths("ambiguous"):
        assert len(truth.twins) == 1
        assert len(truth.near_misses) == 2


def test_absent_scenes_mean_nothing_that_is_there() -> None:
    for truth in truths("absent"):
        assert truth.target is None
        assert truth.relation is None
        assert 2 <= len(truth.near_misses) <= 4


def test_rejected_attempts_are_counted_by_reason() -> None:
    for family in FAMILIES:
        for truth in truths(family):
            assert sum(truth.rejected.values()) == truth.attempts - 1


def test_a_seed_without_a_scene_is_an_error_that_names_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generator, "MAX_ATTEMPTS", 0)
    with pytest.raises(GeneratorError, match="partial scene for seed 5"):
        generate("partial", 5)


def test_the_plan_of_a_scene_is_the_seeds_plan() -> None:
    for family in FAMILIES:
        made, plan = scene(family, 3), plan_of(family, 3)
        assert len(made.scene.bodies) == len(plan.parts)
        assert made.target.relation == plan.relation_asked
