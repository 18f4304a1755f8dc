"""Where everything of a plan stands: container, screens, bodies (pure).

A layout is a proposal: `rejection` says whether the scene shows what its family asks.
"""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.messages import Container, Screen, Xyz
from surefetch.evaluation import layout_screens, layout_sizes
from surefetch.evaluation.layout_ground import (
    AREA_MAX_M,
    AREA_MIN_M,
    Ground,
    Rectangle,
    Views,
    box_corners,
)
from surefetch.evaluation.layout_screens import Sight
from surefetch.evaluation.layout_sizes import WALL_M, ContainerKind
from surefetch.evaluation.scene_plan import Part, Plan
from surefetch.executor.scene_bodies import LID_OVERHANG_M

TRIES: Final = 60
YAW_MARKED_RAD: Final = float(np.radians(15.0))
YAW_FILLER_RAD: Final = float(np.radians(40.0))
GAP_M: Final = 0.016
ROOM_FOR_FINGERS_M: Final = 0.026
"""Around what may be grasped."""
WALL_GAP_M: Final = 0.008
BESIDE_M: Final = (0.010, 0.040)
UNPAINTED: Final = (0.0, 0.0, 0.0)


class NoRoom(Exception):
    """Something found no place; another attempt may."""


@dataclass(frozen=True)
class Placed:
    """One body of the plan with its place."""

    part: Part
    size_m: Xyz
    position_world_m: Xyz
    yaw_rad: float


@dataclass(frozen=True)
class Layout:
    """A laid-out plan; the container is not painted yet."""

    container: Container
    screens: tuple[Screen, ...]
    placed: tuple[Placed, ...]
    """In the plan's order."""


@dataclass
class _Table:
    """A table in the making."""

    plan: Plan
    views: Views
    rng: np.random.Generator
    container: Container
    ground: Ground = field(default_factory=Ground)
    inside: list[tuple[float, float, float]] = field(default_factory=list)
    screens: list[Screen] = field(default_factory=list)
    placed: dict[int, Placed] = field(default_factory=dict)


def lay_out(plan: Plan, views: Views, rng: np.random.Generator) -> Layout:
    """One attempt. Raises NoRoom."""
    container = _container(plan, views, rng)
    table = _Table(plan, views, rng, container)
    table.ground.rectangles.append(footprint(container))
    for k in _hardest_first(plan):
        _place(table, k, plan.parts[k])
    if plan.empty_screen:
        _empty_screen(table)
    return Layout(
        container, tuple(table.screens), tuple(table.placed[k] for k in range(len(plan.parts)))
    )


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


def _container(plan: Plan, views: Views, rng: np.random.Generator) -> Container:
    kind = _kind(plan, rng)
    filled = any(part.relation == "inside" for part in plan.parts)
    low, high = WALL_M[kind]
    if kind == "tray" and plan.covered and filled:
        low = 0.037
    long, short = rng.uniform(*layout_sizes.INNER_LONG_M), rng.uniform(*layout_sizes.INNER_SHORT_M)
    inner = (long, short) if rng.random() < 0.5 else (short, long)
    wall, thickness = float(rng.uniform(low, high)), float(rng.uniform(0.004, 0.007))
    for _ in range(TRIES):
        far = 1.02 if plan.family == "ambiguous" else AREA_MAX_M[0]
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


def _place(table: _Table, k: int, part: Part) -> None:
    """Find a place for one body, screens and all."""
    for _ in range(TRIES):
        size = _size(table, part)
        marked = part.role in ("target", "twin", "near miss")
        spread = YAW_MARKED_RAD if marked else YAW_FILLER_RAD
        yaw = float(table.rng.uniform(-spread, spread))
        if part.relation == "inside":
            found = _inside(table, part, size)
        elif part.hiding == "beside container":
            found = _beside(table, part, size)
        elif part.role == "occluder":
            found = _in_front(table, part, size)
        else:
            found = _anywhere(table, part, size)
        if found is None or (marked and not _shown(table, found, part, size)):
            continue
        screens = _screens(table, part, found, size, yaw)
        if screens is None:
            continue
        radius = layout_sizes.radius_m(size, part.attributes.shape)
        bottom = layout_sizes.rests_above_m(part.attributes.shape)
        if part.relation == "inside":
            bottom += table.container.floor_thickness_m
        if part.relation == "inside":
            table.inside.append((float(found[0]), float(found[1]), radius))
        else:
            table.ground.take(found, radius)
        table.screens += screens
        table.ground.rectangles += [layout_screens.standing(one) for one in screens]
        table.placed[k] = Placed(part, size, (float(found[0]), float(found[1]), bottom), yaw)
        return
    raise NoRoom(part.role)


def _size(table: _Table, part: Part) -> Xyz:
    shape, rng = part.attributes.shape, table.rng
    if part.role == "wide":
        return layout_sizes.wide_size(rng, shape)
    if part.role == "occluder":
        return max(
            (layout_sizes.body_size(shape, rng, widest_m=0.070) for _ in range(6)),
            key=lambda size: size[2] * min(size[:2]),
        )
    if part.relation == "inside":
        container = table.container
        room = container.wall_height_m - container.floor_thickness_m - layout_sizes.BELOW_RIM_M
        highest = room if container.covered else 0.075
        return layout_sizes.body_size(shape, rng, highest_m=highest, widest_m=0.050)
    if part.hiding in ("screen", "corner"):
        return layout_sizes.body_size(shape, rng, highest_m=0.070, widest_m=0.058)
    return layout_sizes.body_size(shape, rng)


def _gap(part: Part) -> float:
    return ROOM_FOR_FINGERS_M if part.role == "target" else GAP_M


def _anywhere(table: _Table, part: Part, size: Xyz) -> Array | None:
    xy: Array = table.rng.uniform(AREA_MIN_M, AREA_MAX_M)
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    return xy if table.ground.free(xy, radius, _gap(part)) else None


def _inside(table: _Table, part: Part, size: Xyz) -> Array | None:
    """Somewhere on the container's floor."""
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    half = np.asarray(table.container.inner_size_m) / 2.0 - radius - WALL_GAP_M
    if (half < 0.0).any():
        return None
    xy = footprint(table.container).world(table.rng.uniform(-half, half)[None])[0]
    near = radius + _gap(part)
    free = all(np.hypot(xy[0] - x, xy[1] - y) > near + r for x, y, r in table.inside)
    return xy if free else None


def _beside(table: _Table, part: Part, size: Xyz) -> Array | None:
    """Within 40 mm of the wall, where the sight line from the first view crosses the container."""
    box = footprint(table.container)
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    towards = np.array([box.x_m, box.y_m]) - table.views.eye_m("center")[:2]
    turned = Rectangle(0.0, 0.0, (1.0, 1.0), box.yaw_rad).local(towards)
    axis = int(np.abs(turned).argmax())
    side = float(np.sign(turned[axis])) * (1.0 if table.rng.random() < 0.6 else -1.0)
    local = np.zeros(2)
    local[axis] = side * (box.size_m[axis] / 2.0 + table.rng.uniform(*BESIDE_M) + radius)
    local[1 - axis] = table.rng.uniform(-0.4, 0.4) * box.size_m[1 - axis]
    xy = box.world(local[None])[0]
    others = Ground(table.ground.discs, table.ground.rectangles[1:])
    return xy if others.free(xy, radius, _gap(part)) else None


def _in_front(table: _Table, part: Part, size: Xyz) -> Array | None:
    """Between the first view's eye and what it must hide."""
    hidden = next(p for p in table.placed.values() if p.part.hiding == "body")
    xy = np.asarray(hidden.position_world_m[:2])
    eye = table.views.eye_m("center")
    shape = hidden.part.attributes.shape
    sight = Sight.of(eye, xy, hidden.size_m, shape, hidden.yaw_rad)
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    back = sight.d_span_m[0] - table.rng.uniform(0.012, 0.040) - radius
    share = table.rng.uniform(*hidden.part.hidden)
    right, left = sight.n_span_m
    side = 1.0 if table.rng.random() < 0.5 else -1.0
    edge = (
        left - (1.0 - share) * (left - right)
        if side > 0
        else right + (1.0 - share) * (left - right)
    )
    place: Array = xy + sight.d * back + sight.n * (edge - side * radius)
    return place if table.ground.free(place, radius, 0.006) else None


def _screens(table: _Table, part: Part, xy: Array, size: Xyz, yaw: float) -> list[Screen] | None:
    """The screens that hide this body; None when they fit nowhere."""
    if part.hiding not in ("screen", "corner"):
        return []
    rng, eye = table.rng, table.views.eye_m("center")
    sight = Sight.of(eye, xy, size, part.attributes.shape, yaw)
    share = float(rng.uniform(*part.hidden))
    if part.hiding == "corner":
        made = [
            layout_screens.beside(sight, share, 1, rng),
            layout_screens.right_wall(sight, table.views.eye_m("right"), rng),
        ]
    elif part.face == "right" and rng.random() < 0.5:
        made = [layout_screens.below(sight, share, rng)]
    else:
        made = [layout_screens.beside(sight, share, 1 if rng.random() < 0.5 else -1, rng)]
    screens = [one for one in made if one is not None]
    stands = [layout_screens.standing(one) for one in screens]
    free = all(table.ground.free_rectangle(one, 0.010) for one in stands)
    return screens if len(screens) == len(made) and free else None


def _shown(table: _Table, xy: Array, part: Part, size: Xyz) -> bool:
    """Whether the body is whole in every view's image."""
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    around = Rectangle(float(xy[0]), float(xy[1]), (2.0 * radius, 2.0 * radius), 0.0)
    return table.views.show(box_corners(around, 0.0, size[2]))


def _empty_screen(table: _Table) -> None:
    rng = table.rng
    for _ in range(TRIES):
        xy = rng.uniform(AREA_MIN_M + 0.05, AREA_MAX_M - 0.05)
        one = Screen(
            size_m=(
                layout_screens.THICKNESS_M,
                float(rng.uniform(0.080, 0.140)),
                float(rng.uniform(0.080, 0.140)),
            ),
            position_world_m=(float(xy[0]), float(xy[1]), 0.0),
            yaw_rad=float(rng.uniform(-0.35, 0.35)),
        )
        if table.ground.free_rectangle(layout_screens.standing(one), 0.025):
            table.screens.append(one)
            table.ground.rectangles.append(layout_screens.standing(one))
            return
    raise NoRoom("screen")
