"""A table in the making: what stands there already (pure)."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from surefetch.common.messages import Body, Container, Screen
from surefetch.evaluation.recordings.recording import FIRST_VIEW
from surefetch.evaluation.scenes.ground import Ground, Rectangle, Views
from surefetch.evaluation.scenes.layout_screens import Sight
from surefetch.evaluation.scenes.plan import Plan
from surefetch.executor.simulation.scene_bodies import LID_OVERHANG_M

UNPAINTED: Final = (0.0, 0.0, 0.0)
UNWEIGHED_KG: Final = 0.1


class NoRoom(Exception):
    """Something found no place; another attempt may."""


@dataclass
class Table:
    """A table in the making."""

    plan: Plan
    views: Views
    rng: np.random.Generator
    container: Container
    ground: Ground = field(default_factory=Ground)
    inside: list[tuple[float, float, float]] = field(default_factory=list)
    screens: list[Screen] = field(default_factory=list)
    bodies: dict[int, Body] = field(default_factory=dict)


def footprint(container: Container) -> Rectangle:
    """The ground under a container, its lid's overhang included when it has one."""
    x, y = container.inner_size_m
    out = container.wall_thickness_m + (LID_OVERHANG_M if container.covered else 0.0)
    return Rectangle(
        container.position_world_m[0],
        container.position_world_m[1],
        (x + 2.0 * out, y + 2.0 * out),
        container.yaw_rad,
    )


def behind_a_body(table: Table) -> tuple[int, Body]:
    """What a body is to hide."""
    return next((k, b) for k, b in table.bodies.items() if table.plan.parts[k].hiding == "body")


def sight_of(table: Table, body: Body) -> Sight:
    xy = np.asarray(body.position_world_m[:2])
    return Sight.of(table.views.eye_m(FIRST_VIEW), xy, body.size_m, body.shape, body.yaw_rad)
