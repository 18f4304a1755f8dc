"""A family and a seed to a scene: the first attempt that keeps every rule.

The rules use geometry, physics and segmentation alone; nothing here may know what perception,
belief or planner make of a scene. Source: rejection rules R1 to R10 of the scenario generator.
"""

from collections import Counter
from dataclasses import dataclass
from typing import Final

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Scene, Target
from surefetch.evaluation import rejection
from surefetch.evaluation.layout import NoRoom
from surefetch.evaluation.scene_truth import SceneTruth
from surefetch.evaluation.scenes import GENERATOR_VERSION, Candidate, draw, plan_of
from surefetch.executor.pybullet_world import PybulletWorld

MAX_ATTEMPTS: Final = 200
SHIFT_M: Final = 0.015
SPEED_M_S: Final = 0.001
OVERLAP_M: Final = 0.001


class GeneratorError(SurefetchError):
    """No attempt at a scene was accepted."""


@dataclass(frozen=True, eq=False)
class GeneratedScene:
    """A scene with the sentence that belongs to it, and the scorer's truth."""

    scene: Scene
    sentence: str
    target: Target
    """What the sentence means."""
    truth: SceneTruth


def generate(family: str, seed: int) -> GeneratedScene:
    """The scene of this address; always the same one.

    Raises:
        BadInput: there is no such family.
        GeneratorError: no attempt was accepted; names family and seed.
    """
    cell, plan = simulated_cell(), plan_of(family, seed)
    rejected: Counter[str] = Counter()
    for attempt in range(MAX_ATTEMPTS):
        try:
            candidate = draw(plan, seed, attempt, cell)
        except NoRoom as error:
            rejected[f"no room for {error}"] += 1
            continue
        reason = _broken_rule(candidate)
        if reason is None:
            return GeneratedScene(
                candidate.scene,
                candidate.sentence,
                candidate.target,
                _truth(candidate, attempt + 1, rejected),
            )
        rejected[reason] += 1
    told = ", ".join(f"{reason} {n}" for reason, n in rejected.most_common())
    raise GeneratorError(
        f"the generator found no {family} scene for seed {seed} in {MAX_ATTEMPTS} attempts "
        f"({told}). This is an error of the generator; the seed must not be skipped."
    )


def _broken_rule(candidate: Candidate) -> str | None:
    for rule in rejection.CHEAP:
        reason = rule(candidate)
        if reason is not None:
            return reason
    with PybulletWorld(candidate.scene, shadows=False) as world:
        return _unsettled(world)


def _unsettled(world: PybulletWorld) -> str | None:
    """R2 before, R1 after two seconds of gravity."""
    if world.deepest_overlap_m() > OVERLAP_M:
        return "R2 penetration"
    if world.settle() > SHIFT_M or world.fastest_m_s() > SPEED_M_S:
        return "R1 not settled"
    return None


def _truth(candidate: Candidate, attempts: int, rejected: Counter[str]) -> SceneTruth:
    plan, bodies = candidate.plan, candidate.scene.bodies
    named = list(zip(plan.parts, (body.name for body in bodies), strict=True))
    return SceneTruth(
        family=plan.family,
        seed=candidate.scene.seed,
        generator_version=GENERATOR_VERSION,
        attempts=attempts,
        rejected=dict(rejected),
        stratum=plan.stratum,
        target=next((name for part, name in named if part.role == "target"), None),
        relation=plan.relation,
        near_misses=tuple(n for p, n in named if p.attributes.shared(plan.asked) == 2),
        twins=tuple(name for part, name in named if part.role == "twin"),
        too_wide=tuple(body.name for body in bodies if rejection.too_wide(body)),
        sightings=(),
        evidence={},
    )
