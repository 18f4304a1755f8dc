"""Where everything of a plan stands: container, screens, bodies (pure).

A layout is a proposal: `rejection` says whether the scene shows what its family asks. What must be
hidden is tried here with its own screens alone, so that most proposals are good ones.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.messages import Body, Container, Screen
from surefetch.evaluation.scenes import layout_screens, layout_sizes
from surefetch.evaluation.scenes.ground import AREA_MAX_M, AREA_MIN_M, Views, box_corners
from surefetch.evaluation.scenes.hiding import as_planned, screens_for
from surefetch.evaluation.scenes.layout_sizes import WALL_M, ContainerKind
from surefetch.evaluation.scenes.places import size_of, spot_for, standing_at
from surefetch.evaluation.scenes.plan import Plan
from surefetch.evaluation.scenes.table import UNPAINTED, NoRoom, Table, footprint

TRIES: Final = 60
TRIES_BESIDE: Final = 150
"""Few places beside a container are such that a body seems to belong to it."""


@dataclass(frozen=True)
class Layout:
    """A laid-out plan; nothing is painted or weighed yet."""

    container: Container
    screens: tuple[Screen, ...]
    bodies: tuple[Body, ...]
    """In the order of the plan's parts."""


def lay_out(plan: Plan, views: Views, rng: np.random.Generator) -> Layout:
    """One attempt. Raises NoRoom."""
    container = _container(plan, views, rng)
    table = Table(plan, views, rng, container)
    table.ground.rectangles.append(footprint(container))
    for k in _hardest_first(plan):
        _place(table, k)
    if plan.empty_screen:
        _empty_screen(table)
    bodies = tuple(table.bodies[k] for k in range(len(plan.parts)))
    return Layout(container, tuple(table.screens), bodies)


def _container(plan: Plan, views: Views, rng: np.random.Generator) -> Container:
    kind = _kind(plan, rng)
    filled = any(part.relation == "inside" for part in plan.parts)
    low, high = WALL_M[kind]
    if kind == "tray" and plan.covered and filled:
        low = 0.037
    long, short = rng.uniform(*layout_sizes.INNER_LONG_M), rng.uniform(*layout_sizes.INNER_SHORT_M)
    inner = (long, short) if rng.random() < 0.5 else (short, long)
    wall, thickness = float(rng.uniform(low, high)), float(rng.uniform(0.004, 0.007))
    far = 1.02 if plan.family == "ambiguous" else AREA_MAX_M[0]
    for _ in range(TRIES):
        x, y = rng.uniform(AREA_MIN_M + 0.07, [far - 0.07, AREA_MAX_M[1] - 0.07])
        made = Container(
            kind=kind,
            inner_size_m=(float(inner[0]), float(inner[1])),
            wall_height_m=wall,
            wall_thickness_m=thickness,
            floor_thickness_m=0.005,
            rgb=UNPAINTED,
            position_world_m=(float(x), float(y), 0.0),
            yaw_rad=float(rng.uniform(-0.35, 0.35)),
            covered=plan.covered,
            lid_rgb=UNPAINTED,
        )
        if views.show(box_corners(footprint(made), 0.0, wall + 0.04 * plan.covered)):
            return made
    raise NoRoom("container")


def _kind(plan: Plan, rng: np.random.Generator) -> ContainerKind:
    if plan.tray:
        return "tray"
    kinds = tuple(WALL_M)
    if plan.identity_hidden and plan.relation == "inside":
        return kinds[int(rng.choice(4, p=(0.6, 0.2, 0.0, 0.2)))]
    weights = {"covered": (0.1, 0.3, 0.3, 0.3), "ambiguous": (0.4, 0.3, 0.0, 0.3)}
    p = weights.get(plan.family, (0.25, 0.25, 0.25, 0.25))
    return kinds[int(rng.choice(4, p=p))]


def _hardest_first(plan: Plan) -> list[int]:
    """What needs a particular place goes first."""

    def rank(k: int) -> int:
        part = plan.parts[k]
        if part.hiding in ("screen", "corner", "beside container"):
            return 0
        if part.hiding == "body":
            return 1
        order = ("occluder", "wide", "target", "twin", "near miss", "filler")
        return 2 + order.index(part.role)

    return sorted(range(len(plan.parts)), key=rank)


def _place(table: Table, k: int) -> None:
    """Find a place for one body, screens and all. Raises NoRoom."""
    part = table.plan.parts[k]
    for _ in range(TRIES_BESIDE if part.hiding == "beside container" else TRIES):
        size = size_of(table, part)
        xy = spot_for(table, part, size)
        if xy is None:
            continue
        body = standing_at(table, k, size, xy)
        screens = screens_for(table, part, body)
        if screens is None or not as_planned(table, part, body, screens):
            continue
        radius = layout_sizes.radius_m(size, body.shape)
        if part.relation == "inside":
            table.inside.append((float(xy[0]), float(xy[1]), radius))
        else:
            table.ground.take(xy, radius)
        table.screens += screens
        table.ground.rectangles += [layout_screens.standing(one) for one in screens]
        table.bodies[k] = body
        return
    raise NoRoom(part.role)


def _empty_screen(table: Table) -> None:
    """A screen that keeps some of the table out of sight. Raises NoRoom."""
    rng = table.rng
    for _ in range(TRIES):
        xy = rng.uniform(AREA_MIN_M + 0.05, AREA_MAX_M - 0.05)
        width, height = rng.uniform(0.080, 0.140), rng.uniform(0.080, 0.140)
        one = Screen(
            size_m=(layout_screens.THICKNESS_M, float(width), float(height)),
            position_world_m=(float(xy[0]), float(xy[1]), 0.0),
            yaw_rad=float(rng.uniform(-0.35, 0.35)),
        )
        if table.ground.free_rectangle(layout_screens.standing(one), 0.025):
            table.screens.append(one)
            table.ground.rectangles.append(layout_screens.standing(one))
            return
    raise NoRoom("screen")
