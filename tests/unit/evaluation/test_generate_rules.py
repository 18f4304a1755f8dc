"""Every rule lets a good scene pass and rejects one that breaks it."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from surefetch.common.cell import simulated_cell
from surefetch.common.messages import Body, Scene, Screen
from surefetch.evaluation.scenes import (
    acceptance,
    generate,
    rejection,
    rejection_reach,
    rejection_sight,
)
from surefetch.evaluation.scenes import sightings as seen
from surefetch.evaluation.scenes.candidate import Candidate, draw, plan_of
from surefetch.evaluation.scenes.ground import Views
from surefetch.executor.simulation.pybullet_world import PybulletWorld

CELL = simulated_cell()


@pytest.fixture(scope="module")
def good() -> Candidate:
    """An accepted attempt at a visible scene."""
    truth = generate.generate("visible", 1).truth
    return draw(plan_of("visible", 1), 1, truth.attempts - 1, CELL)


def with_target(candidate: Candidate, **changes: object) -> Candidate:
    """The same scene with another target."""
    target = target_of(candidate)
    bodies = tuple(
        msgspec.structs.replace(body, **changes) if body == target else body
        for body in candidate.scene.bodies
    )
    return replace(candidate, scene=msgspec.structs.replace(candidate.scene, bodies=bodies))


def target_of(candidate: Candidate) -> Body:
    body = candidate.body("target")
    assert body is not None
    return body


def test_a_good_scene_keeps_the_cheap_rules_and_is_in_reach(good: Candidate) -> None:
    assert [rule(good) for rule in rejection.CHEAP] == [None] * len(rejection.CHEAP)
    assert rejection_reach.reach(good.scene, target_of(good), CELL) is None


def test_a_target_wider_than_the_hand_is_rejected(good: Candidate) -> None:
    wide = with_target(good, shape="cylinder", size_m=(0.15, 0.15, 0.05))
    assert rejection.aperture(wide) == "R4 aperture"


def test_a_target_out_of_reach_is_rejected(good: Candidate) -> None:
    far = with_target(good, position_world_m=(1.6, 0.0, 0.0))
    assert rejection_reach.reach(far.scene, target_of(far), CELL) == "R3 grasp"


def test_a_target_between_walls_is_rejected(good: Candidate) -> None:
    boxed = walled_in(good, 0.05, 0.15)
    assert rejection_reach.reach(boxed, target_of(good), CELL) == "R3 grasp"


def test_a_body_on_the_wall_is_rejected(good: Candidate) -> None:
    container = good.scene.container
    assert container is not None
    half = np.array([container.inner_size_m[0] / 2.0, 0.0])
    c, s = np.cos(container.yaw_rad), np.sin(container.yaw_rad)
    x, y = np.asarray(container.position_world_m[:2]) + np.array([[c, -s], [s, c]]) @ half
    astride = with_target(good, position_world_m=(float(x), float(y), 0.0))
    assert rejection.relation_of(target_of(astride), container) is None
    assert rejection.boundary(astride) == "R9 boundary"


def test_bodies_in_one_another_are_rejected(good: Candidate) -> None:
    other = next(b for b in good.scene.bodies if b != target_of(good))
    nested = with_target(good, position_world_m=other.position_world_m)
    with PybulletWorld(nested.scene, shadows=False) as world, pytest.raises(generate.Rejected) as e:
        generate._settled(world)
    assert str(e.value) == "R2 penetration"


def test_a_body_that_falls_is_rejected(good: Candidate) -> None:
    x, y, _ = target_of(good).position_world_m
    floating = with_target(good, position_world_m=(x, y, 0.30))
    with (
        PybulletWorld(floating.scene, shadows=False) as world,
        pytest.raises(generate.Rejected) as error,
    ):
        generate._settled(world)
    assert str(error.value) == "R1 not settled"


def test_a_second_body_that_fits_the_sentence_is_rejected(good: Candidate) -> None:
    target = next(part for part in good.plan.parts if part.role == "target")
    doubled = replace(good, plan=replace(good.plan, parts=(*good.plan.parts, target)))
    assert rejection.unique(doubled) == "R6 not unique"


def test_a_scene_without_near_misses_is_rejected(good: Candidate) -> None:
    without = tuple(part for part in good.plan.parts if part.role != "near miss")
    assert rejection.counts(replace(good, plan=replace(good.plan, parts=without))) == "R8 counts"


def test_a_hidden_target_is_neither_visible_nor_identifiable(good: Candidate) -> None:
    """Four high walls around it."""
    look = _rays(walled_in(good, 0.06, 0.60))
    assert rejection_sight.visible(good.plan, look) == "R7 occlusion"
    assert rejection_sight.identifiable(good.plan, look) == "R5 not identifiable"


def test_rays_and_renders_see_the_same(good: Candidate) -> None:
    """Within a few hundredths, for every body, view and state of the lid."""
    for family in ("partial", "covered"):
        truth = generate.generate(family, 2).truth
        candidate = draw(plan_of(family, 2), 2, truth.attempts - 1, CELL)
        rays = _rays(candidate.scene)
        names = [body.name for body in candidate.scene.bodies]
        for one in truth.sightings:
            guess = rays(names.index(one.body), one.view, one.cover)
            assert guess.share == pytest.approx(one.share, abs=0.06)


def test_acceptance_counts_attempts_and_reasons_of_each_family() -> None:
    truths = [generate.generate("visible", seed).truth for seed in (1, 2)]
    found = acceptance.by_family(truths)["visible"]
    assert found.scenes == 2
    assert found.attempts == sum(truth.attempts for truth in truths)
    assert sum(found.rejected.values()) == found.attempts - found.scenes


def _rays(scene: Scene) -> rejection_sight.Look:
    return seen.by_rays(scene, Views.of(CELL, scene.camera))


def walled_in(candidate: Candidate, gap_m: float, height_m: float) -> Scene:
    """The scene with nothing but four screens around the target."""
    x, y, _ = target_of(candidate).position_world_m
    sides = ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, np.pi / 2), (0.0, -1.0, np.pi / 2))
    walls = tuple(
        Screen(
            size_m=(0.008, 0.14, height_m),
            position_world_m=(x + gap_m * dx, y + gap_m * dy, 0.0),
            yaw_rad=yaw,
        )
        for dx, dy, yaw in sides
    )
    return msgspec.structs.replace(candidate.scene, screens=walls)
