"""How large a part is drawn, and where it may stand (pure)."""

from typing import Final

import numpy as np

from surefetch.common.geometry import Array
from surefetch.common.messages import Body, Marking, Xyz
from surefetch.evaluation.recordings.recording import FIRST_VIEW
from surefetch.evaluation.scenes import layout_screens, layout_sizes
from surefetch.evaluation.scenes.ground import (
    AREA_MAX_M,
    AREA_MIN_M,
    Ground,
    Rectangle,
    box_corners,
)
from surefetch.evaluation.scenes.plan import Part
from surefetch.evaluation.scenes.table import (
    UNPAINTED,
    UNWEIGHED_KG,
    Table,
    behind_a_body,
    footprint,
    sight_of,
)

YAW_MARKED_RAD: Final = float(np.radians(15.0))
YAW_FILLER_RAD: Final = float(np.radians(40.0))
GAP_M: Final = 0.016
ROOM_FOR_FINGERS_M: Final = 0.026
"""Around what is to be grasped."""
WALL_GAP_M: Final = 0.008
BESIDE_M: Final = (0.010, 0.040)
COVERAGE: Final = (0.30, 0.60)
"""Share of its face that a marking covers."""


def size_of(table: Table, part: Part) -> Xyz:
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


def spot_for(table: Table, part: Part, size: Xyz) -> Array | None:
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


def _anywhere(table: Table, part: Part, size: Xyz) -> Array | None:
    xy: Array = table.rng.uniform(AREA_MIN_M, AREA_MAX_M)
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    return xy if table.ground.free(xy, radius, _gap(part)) else None


def _inside(table: Table, part: Part, size: Xyz) -> Array | None:
    """Somewhere on the container's floor."""
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    half = np.asarray(table.container.inner_size_m) / 2.0 - radius - WALL_GAP_M
    if (half < 0.0).any():
        return None
    xy: Array = footprint(table.container).world(table.rng.uniform(-half, half)[None])[0]
    near = radius + _gap(part)
    free = all(np.hypot(xy[0] - x, xy[1] - y) > near + r for x, y, r in table.inside)
    return xy if free else None


def _beside(table: Table, part: Part, size: Xyz) -> Array | None:
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


def _in_front(table: Table, part: Part, size: Xyz) -> Array | None:
    """Between the first view's eye and what it must hide."""
    k, hidden = behind_a_body(table)
    sight = sight_of(table, hidden)
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    back = sight.d_span_m[0] - table.rng.uniform(0.012, 0.040) - radius
    side = 1.0 if table.rng.random() < 0.5 else -1.0
    edge = layout_screens.edge_of(
        sight, float(table.rng.uniform(*table.plan.parts[k].hidden)), side
    )
    place: Array = sight.xy_m + sight.d * back + sight.n * (edge - side * radius)
    return place if table.ground.free(place, radius, 0.006) else None


def _shown(table: Table, xy: Array, part: Part, size: Xyz) -> bool:
    """Whether the body is whole in every view's image."""
    radius = layout_sizes.radius_m(size, part.attributes.shape)
    around = Rectangle(float(xy[0]), float(xy[1]), (2.0 * radius, 2.0 * radius), 0.0)
    return table.views.show(box_corners(around, 0.0, size[2]))


def standing_at(table: Table, k: int, size: Xyz, xy: Array) -> Body:
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
