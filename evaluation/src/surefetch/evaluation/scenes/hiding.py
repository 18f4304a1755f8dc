"""Whether the first view is kept from what the plan hides, and the screens for it (pure)."""

from surefetch.common.messages import Body, Screen
from surefetch.evaluation.recordings.recording import FIRST_VIEW
from surefetch.evaluation.scenes import layout_screens, layout_sizes, rejection_sight
from surefetch.evaluation.scenes.ground import Ground
from surefetch.evaluation.scenes.plan import Part
from surefetch.evaluation.scenes.sightlines import Sightlines
from surefetch.evaluation.scenes.table import Table, behind_a_body, sight_of


def screens_for(table: Table, part: Part, body: Body) -> list[Screen] | None:
    """The screens that hide this body; None when they fit nowhere."""
    if part.hiding not in ("screen", "corner"):
        return []
    rng, sight = table.rng, sight_of(table, body)
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


def as_planned(table: Table, part: Part, body: Body, screens: list[Screen]) -> bool:
    """Whether the first view is kept from what the plan hides, as far as this body decides it."""
    if part.role == "occluder":
        k, hidden = behind_a_body(table)
        return _hidden(table, table.plan.parts[k], hidden, [body], [])
    if part.hiding in ("screen", "corner"):
        return _hidden(table, part, body, [], screens) and _unreadable(table, body, screens)
    if part.hiding == "beside container" and not _confusable(table, body):
        return False
    decides = part.role in ("target", "near miss") and part.face == "right"
    return not decides or _unreadable(table, body, [])


def _hidden(
    table: Table, part: Part, body: Body, others: list[Body], screens: list[Screen]
) -> bool:
    lines = _sightlines(table, [body, *others], screens)
    low, high = part.hidden
    return low <= 1.0 - lines.of_body(body.name, FIRST_VIEW).share <= high


def _unreadable(table: Table, body: Body, screens: list[Screen]) -> bool:
    lines = _sightlines(table, [body], screens)
    seen = lines.of_patch(body.name, FIRST_VIEW)
    return rejection_sight.tells_nothing(seen.pixels, seen.share)


def _sightlines(table: Table, bodies: list[Body], screens: list[Screen]) -> Sightlines:
    """These and the open container."""
    return Sightlines(bodies, screens, table.container, table.views, lid=False)


def _confusable(table: Table, body: Body) -> bool:
    """Whether the body seems to belong to the container where the plan wants it to seem so."""
    lines = Sightlines([body], [], table.container, table.views, lid=True)
    first = lines.over_container(body.name, FIRST_VIEW)
    if first < rejection_sight.OVER:
        return False
    right, above = (lines.over_container(body.name, view) for view in rejection_sight.OTHER_VIEWS)
    return (
        rejection_sight.confusable(first, right, above, table.plan.clear_right)
        and lines.of_body(body.name, FIRST_VIEW).share >= rejection_sight.TWIN_SHARE
    )
