"""A family and a seed to a scene: the first attempt that keeps every rule.

The rules use geometry, physics and segmentation alone; nothing here may know what perception,
belief or planner make of a scene. Source: rejection rules R1 to R10 of the scenario generator.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Scene, Target
from surefetch.evaluation.scenes import rejection, rejection_reach, rejection_sight, sightings
from surefetch.evaluation.scenes.candidate import GENERATOR_VERSION, Candidate, draw, plan_of
from surefetch.evaluation.scenes.ground import Views
from surefetch.evaluation.scenes.plan import Plan
from surefetch.evaluation.scenes.rejection_sight import Look
from surefetch.evaluation.scenes.table import NoRoom
from surefetch.evaluation.scenes.truth import SceneTruth
from surefetch.executor.simulation.pybullet_world import PybulletWorld

MAX_ATTEMPTS: Final = 200
SHIFT_M: Final = 0.015
SPEED_M_S: Final = 0.001
OVERLAP_M: Final = 0.001


class GeneratorError(SurefetchError):
    """No attempt at a scene was accepted."""


class Rejected(Exception):
    """A rule is broken; the text is what the histogram counts."""


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
            return attempted(plan, seed, attempt, cell, rejected)
        except NoRoom as error:
            rejected[f"no room for {error}"] += 1
        except Rejected as error:
            rejected[str(error)] += 1
    told = ", ".join(f"{reason} {n}" for reason, n in rejected.most_common())
    raise GeneratorError(
        f"the generator found no {family} scene for seed {seed} in {MAX_ATTEMPTS} attempts "
        f"({told}). This is an error of the generator; the seed must not be skipped."
    )


def attempted(
    plan: Plan, seed: int, attempt: int, cell: Cell, rejected: Mapping[str, int]
) -> GeneratedScene:
    """One attempt, the cheapest rules first.

    Raises:
        NoRoom: the layout found no place for something.
        Rejected: a rule is broken.
    """
    candidate = draw(plan, seed, attempt, cell)
    for rule in rejection.CHEAP:
        _keep(rule(candidate))
    scene, views = candidate.scene, Views.of(cell, candidate.scene.camera)
    estimate = sightings.by_rays(scene, views)
    _keep_in_sight(plan, estimate)
    _keep(rejection_reach.reach(scene, candidate.body("target"), cell))
    with PybulletWorld(scene, shadows=False) as world:
        evidence = _settled(world)
        look = sightings.by_renders(world, views, estimate)
        _keep_in_sight(plan, look)
        truth = _truth(candidate, attempt + 1, rejected, look, evidence)
    return GeneratedScene(scene, candidate.sentence, candidate.target, truth)


def _keep(broken: str | None) -> None:
    if broken is not None:
        raise Rejected(broken)


def _keep_in_sight(plan: Plan, look: Look) -> None:
    """R7 and R5."""
    _keep(rejection_sight.FAMILY[plan.family](plan, look))
    _keep(rejection_sight.identifiable(plan, look))


def _settled(world: PybulletWorld) -> dict[str, float]:
    """R2 before, R1 after two seconds of gravity."""
    overlap = world.deepest_overlap_m()
    _keep("R2 penetration" if overlap > OVERLAP_M else None)
    shift, speed = world.settle(), world.fastest_m_s()
    _keep("R1 not settled" if shift > SHIFT_M or speed > SPEED_M_S else None)
    return {"overlap_m": overlap, "shift_m": shift, "speed_m_s": speed}


def _truth(
    candidate: Candidate,
    attempts: int,
    rejected: Mapping[str, int],
    look: Look,
    evidence: dict[str, float],
) -> SceneTruth:
    plan, bodies = candidate.plan, candidate.scene.bodies
    named = list(zip(plan.parts, (body.name for body in bodies), strict=True))
    target = candidate.body("target")
    width = {} if target is None else {"target_width_m": rejection.width_m(target)}
    return SceneTruth(
        family=plan.family,
        seed=candidate.scene.seed,
        generator_version=GENERATOR_VERSION,
        attempts=attempts,
        rejected=dict(rejected),
        stratum=plan.stratum,
        target=None if target is None else target.name,
        relation=plan.relation,
        near_misses=tuple(n for p, n in named if p.attributes.shared(plan.asked) == 2),
        twins=tuple(name for part, name in named if part.role == "twin"),
        too_wide=tuple(body.name for body in bodies if rejection.too_wide(body)),
        sightings=tuple(sightings.all_of(plan, look)),
        evidence=evidence | width,
    )
