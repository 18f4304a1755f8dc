"""Rules that a candidate must keep before anything is simulated (pure).

Each returns nothing when the rule is kept, else the reason that the histogram counts.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from surefetch.common.hypotheses import Relation
from surefetch.common.messages import Body, Container
from surefetch.evaluation.scenes import layout_sizes
from surefetch.evaluation.scenes.candidate import Candidate
from surefetch.evaluation.scenes.ground import Rectangle
from surefetch.executor.robot import ur10e
from surefetch.executor.simulation import scene_meshes

CLEARANCE_M: Final = 0.010
"""On each side of a body between open fingers."""
OUTSIDE_M: Final = 0.008
"""Between an outer wall and the footprint of what stands outside."""

Rule = Callable[[Candidate], str | None]


def width_m(body: Body) -> float:
    """The narrowest that fingers could close on, over all yaws."""
    return min(body.size_m[0], body.size_m[1])


def too_wide(body: Body) -> bool:
    """Whether no opening of the hand leaves the clearance on both sides."""
    return width_m(body) + 2.0 * CLEARANCE_M > ur10e.WIDTH_MAX_M


def relation_of(body: Body, container: Container) -> Relation | None:
    """Geometric truth; None when the body straddles the container's boundary."""
    x, y, bottom = body.position_world_m
    t = container.wall_thickness_m
    inner_x, inner_y = container.inner_size_m
    box = Rectangle(
        container.position_world_m[0],
        container.position_world_m[1],
        (inner_x, inner_y),
        container.yaw_rad,
    )
    dx, dy = np.abs(box.local(np.array([x, y])))
    if dx < inner_x / 2.0 and dy < inner_y / 2.0 and bottom < container.wall_height_m:
        return "inside"
    outer = Rectangle(box.x_m, box.y_m, (inner_x + 2.0 * t, inner_y + 2.0 * t), box.yaw_rad)
    apart = outer.distance_m(np.array([x, y])) - layout_sizes.radius_m(body.size_m, body.shape)
    return "outside" if apart >= OUTSIDE_M or _corners_apart(body, outer) else None


def _corners_apart(body: Body, outer: Rectangle) -> bool:
    """Whether every corner of the footprint keeps its distance from the outer walls."""
    x, y, _ = body.position_world_m
    turned = Rectangle(x, y, (1.0, 1.0), body.yaw_rad)
    corners = turned.world(scene_meshes.outline(body.shape, body.size_m))
    return all(outer.distance_m(corner) >= OUTSIDE_M for corner in corners)


def aperture(candidate: Candidate) -> str | None:
    """R4: the target fits between the fingers at some yaw."""
    target = candidate.body("target")
    return "R4 aperture" if target is not None and too_wide(target) else None


def boundary(candidate: Candidate) -> str | None:
    """R9, and every body stands where the plan wants it."""
    container = candidate.scene.container
    assert container is not None
    for part, body in zip(candidate.plan.parts, candidate.scene.bodies, strict=True):
        if relation_of(body, container) != part.relation:
            return "R9 boundary"
        inside_lid = part.relation == "inside" and container.covered
        if inside_lid and body.position_world_m[2] + body.size_m[2] > container.wall_height_m:
            return "R9 higher than the rim"
    return None


def unique(candidate: Candidate) -> str | None:
    """R6: exactly one body fits attributes and relation; none in an absent scene."""
    plan = candidate.plan
    fitting = [
        part
        for part in plan.parts
        if plan.matches(part.attributes) and plan.relation_asked in ("any", part.relation)
    ]
    wanted = 0 if plan.relation is None else 1
    return None if len(fitting) == wanted else "R6 not unique"


def counts(candidate: Candidate) -> str | None:
    """R8: how many near-misses and twins the family has, and where."""
    plan = candidate.plan
    shared = [(part.attributes.shared(plan.asked), part) for part in plan.parts]
    misses = [part for n, part in shared if n == 2]
    twins = [part for n, part in shared if n == 3 and part.role != "target"]
    sides = {part.relation for part in misses}
    kept = {
        "visible": len(misses) >= 1 and not twins,
        "partial": 1 <= len(misses) <= 2 and not twins,
        "covered": sides == {"inside", "outside"} and len(twins) <= 1,
        "ambiguous": sides == {"inside", "outside"} and len(misses) == 2 and len(twins) == 1,
        "absent": 2 <= len(misses) <= 4 and len(twins) <= 1,
    }[plan.family]
    return None if kept else "R8 counts"


CHEAP: Final[tuple[Rule, ...]] = (aperture, unique, counts, boundary)
