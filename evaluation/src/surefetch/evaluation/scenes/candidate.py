"""A family, a seed and an attempt to a candidate scene (pure): plan, places, colours, light, words.

Nothing here checks that the scene is any good; `generate` does.
"""

from dataclasses import dataclass
from typing import Final

import msgspec
import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.messages import Body, CameraSpec, Container, Scene, Target
from surefetch.common.streams import stream
from surefetch.evaluation.scenes import appearance, families, layout, layout_sizes, sentence
from surefetch.evaluation.scenes.ground import Views
from surefetch.evaluation.scenes.layout import Layout
from surefetch.evaluation.scenes.plan import Plan, Role

GENERATOR_VERSION: Final = 4
"""Increases with every change that gives a seed another scene; versions are never mixed."""


@dataclass(frozen=True)
class Candidate:
    """One attempt at a scene. `scene.bodies` are in the order of the plan's parts."""

    plan: Plan
    scene: Scene
    sentence: str
    target: Target

    def body(self, role: Role) -> Body | None:
        """The first body of this role."""
        pairs = zip(self.plan.parts, self.scene.bodies, strict=True)
        return next((body for part, body in pairs if part.role == role), None)


def plan_of(family: str, seed: int) -> Plan:
    """The plan that all attempts of a seed share. Raises BadInput for an unknown family."""
    return families.draw_plan(family, stream(family, seed, "layout"))


def draw(plan: Plan, seed: int, attempt: int, cell: Cell) -> Candidate:
    """The attempt's candidate. Raises layout_table.NoRoom."""
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
    bodies = tuple(
        _body(k, part.attributes.color, body, rng)
        for k, (part, body) in enumerate(zip(plan.parts, laid.bodies, strict=True))
    )
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


def _body(k: int, color: str, body: Body, rng: np.random.Generator) -> Body:
    """Painted and weighed, and named for people who read figures."""
    rgb = appearance.jittered(appearance.COLORS[color], rng)
    assert body.marking is not None
    marking = msgspec.structs.replace(body.marking, rgb=appearance.marking_rgb(rgb))
    return msgspec.structs.replace(
        body,
        name=f"{k} {color} {body.shape} {marking.kind}",
        rgb=rgb,
        marking=marking,
        mass_kg=layout_sizes.mass_kg(body.size_m, rng),
    )
