"""A family, a seed and an attempt to a candidate scene (pure): plan, places, colours, light, words.

Nothing here checks that the scene is any good; `generate` does.
"""

from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.messages import Body, CameraSpec, Container, Marking, Rgb, Scene, Target
from surefetch.common.streams import stream
from surefetch.evaluation import appearance, layout, layout_sizes, scene_plan, sentence
from surefetch.evaluation.layout import Layout, Placed
from surefetch.evaluation.layout_ground import Views
from surefetch.evaluation.scene_plan import Plan

GENERATOR_VERSION: Final = 1
"""Increases with every change that gives a seed another scene; versions are never mixed."""
VOCABULARY_VERSION: Final = "v1"
COVERAGE: Final = (0.30, 0.60)


@dataclass(frozen=True)
class Candidate:
    """One attempt at a scene. `scene.bodies` are in the order of the plan's parts."""

    plan: Plan
    scene: Scene
    sentence: str
    target: Target


def plan_of(family: str, seed: int) -> Plan:
    """The plan that all attempts of a seed share. Raises BadInput for an unknown family."""
    return scene_plan.draw_plan(family, stream(family, seed, "layout"))


def draw(plan: Plan, seed: int, attempt: int, cell: Cell) -> Candidate:
    """The attempt's candidate. Raises layout.NoRoom."""
    camera = CameraSpec(
        width=cell.camera.width,
        height=cell.camera.height,
        vertical_fov_deg=cell.camera.vertical_fov_deg,
    )
    views = Views.of(cell, camera)
    laid = layout.lay_out(plan, views, stream(plan.family, seed, "layout", attempt))
    rng = stream(plan.family, seed, "appearance", attempt)
    scene = _painted(plan, seed, laid, camera, rng)
    target = target_of(plan, laid.container, stream(plan.family, seed, "sentence"))
    said = sentence.draw_sentence(target, stream(plan.family, seed, "sentence", "words"))
    return Candidate(plan, scene, said, target)


def target_of(plan: Plan, container: Container, rng: np.random.Generator) -> Target:
    """What the sentence means."""
    named = {name: getattr(plan.asked, name) for name in plan.named}
    noun = sentence.NOUNS[int(rng.integers(len(sentence.NOUNS)))]
    word = sentence.CONTAINER_WORDS[container.kind]
    return Target(
        noun=named.get("shape", noun),
        color=named.get("color"),
        shape=named.get("shape"),
        marking=named.get("marking"),
        relation=plan.relation_asked,
        container="box" if plan.relation_asked == "any" else word,
    )


def _painted(
    plan: Plan, seed: int, laid: Layout, camera: CameraSpec, rng: np.random.Generator
) -> Scene:
    box_rgb, lid_rgb = appearance.container_colors(rng, plan.asked.color)
    container = msgspec.structs.replace(laid.container, rgb=box_rgb, lid_rgb=lid_rgb)
    bodies = tuple(_body(k, placed, rng) for k, placed in enumerate(laid.placed))
    return Scene(
        family=plan.family,
        seed=seed,
        generator_version=GENERATOR_VERSION,
        bodies=bodies,
        container=container,
        screens=laid.screens,
        lighting=appearance.lighting(rng),
        table_rgb=appearance.table_rgb(rng),
        camera=camera,
    )


def _body(k: int, placed: Placed, rng: np.random.Generator) -> Body:
    look = placed.part.attributes
    rgb = appearance.jittered(appearance.COLORS[look.color], rng)
    return Body(
        name=f"{k} {look.color} {look.shape} {look.marking}",
        shape=look.shape,
        size_m=placed.size_m,
        rgb=rgb,
        marking=_marking(placed, rgb, rng),
        mass_kg=layout_sizes.mass_kg(placed.size_m, rng),
        position_world_m=placed.position_world_m,
        yaw_rad=placed.yaw_rad,
    )


def _marking(placed: Placed, rgb: Rgb, rng: np.random.Generator) -> Marking:
    """Plain bodies too: where their patch would be."""
    return Marking(
        kind=placed.part.attributes.marking,
        face=placed.part.face,
        rgb=appearance.marking_rgb(rgb),
        coverage=float(rng.uniform(*COVERAGE)),
    )
