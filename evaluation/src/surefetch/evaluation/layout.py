"""Where everything of a plan stands: container, screens, bodies (pure).

A layout is a proposal: `rejection` says whether the scene shows what its family asks. What must be
hidden is tried here with its own screens alone, so that most proposals are good ones.
"""

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.messages import Body, Container, Marking, Screen, Xyz
from surefetch.evaluation import layout_screens, layout_sizes, rejection_sight
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
from surefetch.evaluation.recording import FIRST_VIEW
from surefetch.evaluation.scene_plan import Part, Plan
from surefetch.evaluation.sightlines import Sightlines
from surefetch.executor.scene_bodies import LID_OVERHANG_M

TRIES: Final = 60
YAW_MARKED_RAD: Final = float(np.radians(15.0))
YAW_FILLER_RAD: Final = float(np.radians(40.0))
GAP_M: Final = 0.016
ROOM_FOR_FINGERS_M: Final = 0.026
"""Around what is to be grasped."""
WALL_GAP_M: Final = 0.008
BESIDE_M: Final = (0.010, 0.040)
COVERAGE: Final = (0.30, 0.60)
"""Share of its face that a marking covers."""
UNPAINTED: Final = (0.0, 0.0, 0.0)
UNWEIGHED_KG: Final = 0.1


class NoRoom(Exception):
    """Something found no place; another attempt may."""


@dataclass(frozen=True)
class Layout:
    """A laid-out plan; nothing is painted or weighed yet."""

    container: Container
    screens: tuple[Screen, ...]
    bodies: tuple[Body, ...]
    """In the order of the plan's parts."""


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
    bodies: dict[int, Body] = field(default_factory=dict)


def lay_out(plan: Plan, views: Views, rng: np.random.Generator) -> Layout:
    """One attempt. Raises NoRoom."""
    container = _container(plan, views, rng)
    table = _Table(plan, views, rng, container)
    table.ground.rectangles.append(footprint(container))
    for k in _hardest_first(plan):
        _place(table, k)
    if plan.empty_screen:
        _empty_screen(table)
    bodies = tuple(table.bodies[k] for k in range(len(plan.parts)))
    return Layout(container, tuple(table.screens), bodies)


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


def _place(table: _Table, k: int) -> None:
    """Find a place for one body, screens and all. Raises NoRoom."""
    part = table.plan.parts[k]
    for _ in range(TRIES):
        size = _size(table, part)
        xy = _spot(table, part, size)
        if xy is None:
            continue
        body = _standing(table, k, size, xy)
        screens = _screens(table, part, body)
        if screens is None or not _as_planned(table, part, body, screens):
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


def _size(table: _Table, part: Part) -> Xyz:
    shape, rng = part.attributes.shape, table.rng
    if part.role == "wide":
        return layout_sizes.wide_size(rng, shape)
    if part.role == "occluder":
        drawn = [layout_sizes.body_size(shape, rng, widest_m=0.070) for _ in range(6)]
        return max(drawn, key=lambda size: size[2] * min(size[:2]))
    if part.relation == "inside":
        container = table.container
        room = container.wall_height_m - container.floor_thickness_m - layout_sizes.BELOW_RIM_M
        highest = room if container.covered else 0.075
        return layout_sizes.body_size(shape, rng, highest_m=highest, widest_m=0.050)
    if part.hiding == "body":
        return layout_sizes.body_size(shape, rng, highest_m=0.050, widest_m=0.045)
    if part.hiding in ("screen", "corner"):
        return layout_sizes.body_size(shape, rng, highest_m=0.070, widest_m=0.055)
    return layout_sizes.body_size(shape, rng)


def _spot(table: _Table, part: Part, size: Xyz) -> Array | None:
    """A free place (2,) of the kind that the part needs, or None."""
    if part.relation == "inside":
        found = _inside(table, part, size)
    elif part.hiding == "beside container":
        found = _beside(table, part, size)
    elif part.role == "occluder":
        found = _in_front(table, part, size)
    else:
        found = _anywhere(table, part, size)
    if found is None or part.role in ("filler", "wide", "occluder"):
        return found
    return found if _shown(table, found, part, size) else None


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
    xy: Array = footprint(table.container).world(table.rng.uniform(-half, half)[None])[0]
    near = radius + _gap(part)
    free = all(np.hypot(xy[0] - x, xy[1] - y) > near + r for x, y, r in table.inside)
    return xy if free else None


def _beside(table: _Table, part: Part, size: Xyz) -> Array | None:
    """Within 40 mm of the wall, before or behind the container as the first view sees it."""
    box = footprint(table.container)
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    towards = np.array([box.x_m, box.y_m]) - table.views.eye_m(FIRST_VIEW)[:2]
    turned = Rectangle(0.0, 0.0, (1.0, 1.0), box.yaw_rad).local(towards)
    axis = int(np.abs(turned).argmax())
    side = float(np.sign(turned[axis])) * (1.0 if table.rng.random() < 0.6 else -1.0)
    local = np.zeros(2)
    local[axis] = side * (box.size_m[axis] / 2.0 + table.rng.uniform(*BESIDE_M) + radius)
    local[1 - axis] = table.rng.uniform(-0.4, 0.4) * box.size_m[1 - axis]
    xy: Array = box.world(local[None])[0]
    others = Ground(table.ground.discs, table.ground.rectangles[1:])
    return xy if others.free(xy, radius, _gap(part)) else None


def _in_front(table: _Table, part: Part, size: Xyz) -> Array | None:
    """Between the first view's eye and what it must hide."""
    k, hidden = _behind_a_body(table)
    sight = _sight(table, hidden)
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    back = sight.d_span_m[0] - table.rng.uniform(0.012, 0.040) - radius
    side = 1.0 if table.rng.random() < 0.5 else -1.0
    edge = layout_screens.edge_of(
        sight, float(table.rng.uniform(*table.plan.parts[k].hidden)), side
    )
    place: Array = sight.xy_m + sight.d * back + sight.n * (edge - side * radius)
    return place if table.ground.free(place, radius, 0.006) else None


def _behind_a_body(table: _Table) -> tuple[int, Body]:
    """What a body is to hide."""
    return next((k, b) for k, b in table.bodies.items() if table.plan.parts[k].hiding == "body")


def _sight(table: _Table, body: Body) -> Sight:
    xy = np.asarray(body.position_world_m[:2])
    return Sight.of(table.views.eye_m(FIRST_VIEW), xy, body.size_m, body.shape, body.yaw_rad)


def _standing(table: _Table, k: int, size: Xyz, xy: Array) -> Body:
    """The body at its place, at rest, its marking's size drawn."""
    part, rng = table.plan.parts[k], table.rng
    decides = part.role in ("target", "twin", "near miss")
    spread = YAW_MARKED_RAD if decides else YAW_FILLER_RAD
    bottom = layout_sizes.rests_above_m(part.attributes.shape)
    if part.relation == "inside":
        bottom += table.container.floor_thickness_m
    return Body(
        name=str(k),
        shape=part.attributes.shape,
        size_m=size,
        rgb=UNPAINTED,
        marking=Marking(
            kind=part.attributes.marking,
            face=part.face,
            rgb=UNPAINTED,
            coverage=float(rng.uniform(*COVERAGE)),
        ),
        mass_kg=UNWEIGHED_KG,
        position_world_m=(float(xy[0]), float(xy[1]), bottom),
        yaw_rad=float(rng.uniform(-spread, spread)),
    )


def _screens(table: _Table, part: Part, body: Body) -> list[Screen] | None:
    """The screens that hide this body; None when they fit nowhere."""
    if part.hiding not in ("screen", "corner"):
        return []
    rng, sight = table.rng, _sight(table, body)
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
    radius = layout_sizes.radius_m(body.size_m, body.shape)
    own = Ground([(*body.position_world_m[:2], radius)])
    free = all(
        table.ground.free_rectangle(one, 0.010) and own.free_rectangle(one, 0.0) for one in stands
    )
    return screens if len(screens) == len(made) and free else None


def _as_planned(table: _Table, part: Part, body: Body, screens: list[Screen]) -> bool:
    """Whether the first view is kept from what the plan hides, as far as this body decides it."""
    if part.role == "occluder":
        k, hidden = _behind_a_body(table)
        return _hidden(table, table.plan.parts[k], hidden, [body], [])
    if part.hiding in ("screen", "corner"):
        return _hidden(table, part, body, [], screens) and _unreadable(table, body, screens)
    if part.hiding == "beside container" and not _confusable(table, body):
        return False
    decides = part.role in ("target", "near miss") and part.face == "right"
    return not decides or _unreadable(table, body, [])


def _hidden(
    table: _Table, part: Part, body: Body, others: list[Body], screens: list[Screen]
) -> bool:
    lines = _sightlines(table, [body, *others], screens)
    low, high = part.hidden
    return low <= 1.0 - lines.of_body(body.name, FIRST_VIEW).share <= high


def _unreadable(table: _Table, body: Body, screens: list[Screen]) -> bool:
    lines = _sightlines(table, [body], screens)
    seen = lines.of_patch(body.name, FIRST_VIEW)
    return rejection_sight.tells_nothing(seen.pixels, seen.share)


def _sightlines(table: _Table, bodies: list[Body], screens: list[Screen]) -> Sightlines:
    """These and the open container."""
    return Sightlines(bodies, screens, table.container, table.views, lid=False)


def _confusable(table: _Table, body: Body) -> bool:
    """Whether the body seems to belong to the container where the plan wants it to seem so."""
    lines = Sightlines([body], [], table.container, table.views, lid=True)
    first, right, above = (lines.over_container(body.name, view) for view in rejection_sight.VIEWS)
    return (
        rejection_sight.confusable(first, right, above, table.plan.clear_right)
        and lines.of_body(body.name, FIRST_VIEW).share >= rejection_sight.TWIN_SHARE
    )


def _shown(table: _Table, xy: Array, part: Part, size: Xyz) -> bool:
    """Whether the body is whole in every view's image."""
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    around = Rectangle(float(xy[0]), float(xy[1]), (2.0 * radius, 2.0 * radius), 0.0)
    return table.views.show(box_corners(around, 0.0, size[2]))


def _empty_screen(table: _Table) -> None:
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
