"""R5 and R7: what each view shows of target, twins and near-misses (pure).

The rules ask a `Look` for sightings, so that the same rules judge the quick estimate by rays and
the final segmentation renders. A view is named with the state of the lid.
"""

from collections.abc import Callable, Iterable
from typing import Final

from surefetch.evaluation.recordings.recording import FIRST_VIEW, Cover
from surefetch.evaluation.scenes.plan import Part, Plan
from surefetch.evaluation.scenes.truth import Sighting

Look = Callable[[int, str, Cover], Sighting]
"""How much of the plan's k-th body a view shows with the lid in this state."""

SHARE: Final = 0.5
PIXELS: Final = 250.0
PATCH_PX: Final = 60.0
UNREADABLE_SHARE: Final = 0.5
"""A patch of which less is seen, and fewer pixels than above, tells nothing."""
OTHER_VIEWS: Final = ("right", "close_high")
VIEWS: Final = (FIRST_VIEW, *OTHER_VIEWS)
TWIN_SHARE: Final = 0.6
"""Of target and twin in `ambiguous`, in the first view that can show them."""
OVER: Final = 0.15
CLEAR: Final = 0.05
"""Shares of a body's outline over the container: from where on they seem one, up to where not."""
NEAR_MISS_SHARE: Final = 0.04
"""Of a near-miss in `partial`: the first view must show that it is there."""


def first_cover(plan: Plan) -> Cover:
    """The lid's state at the start."""
    return "closed" if plan.covered else "none"


def open_cover(plan: Plan) -> Cover:
    """The lid's state in which everything can be seen."""
    return "open" if plan.covered else "none"


def readable(sighting: Sighting, marking: bool) -> bool:
    """Whether a view tells what the body is; its marking only where it matters."""
    return (
        sighting.share >= SHARE
        and sighting.pixels >= PIXELS
        and (not marking or sighting.patch_px >= PATCH_PX)
    )


def unreadable(sighting: Sighting) -> bool:
    """Whether a view tells nothing of the body's marking."""
    return tells_nothing(sighting.patch_px, sighting.patch_share)


def tells_nothing(patch_px: float, patch_share: float) -> bool:
    """Whether this much of a patch is too little to read."""
    return patch_px < PATCH_PX and patch_share < UNREADABLE_SHARE


def identifiable(plan: Plan, look: Look) -> str | None:
    """R5: some state shows enough of the target, the deciding patch included."""
    k = _target(plan)
    if k is None or any(readable(one, _marked(plan)) for one in _all(plan, k, look)):
        return None
    return "R5 not identifiable"


def _target(plan: Plan) -> int | None:
    return next((k for k, part in enumerate(plan.parts) if part.role == "target"), None)


def _marked(plan: Plan) -> bool:
    return "marking" in plan.named


def _all(plan: Plan, k: int, look: Look) -> Iterable[Sighting]:
    """Every state that can be recorded under the base rule: the views need an open container."""
    yield look(k, FIRST_VIEW, first_cover(plan))
    for view in VIEWS if plan.covered else OTHER_VIEWS:
        yield look(k, view, open_cover(plan))


def _others(plan: Plan, role: str) -> list[tuple[int, Part]]:
    return [(k, part) for k, part in enumerate(plan.parts) if part.role == role]


def visible(plan: Plan, look: Look) -> str | None:
    """The first view shows nearly all of the target and reads it; one or two more do."""
    k = _target(plan)
    assert k is not None
    first = look(k, FIRST_VIEW, first_cover(plan))
    if first.share < 0.85:
        return "R7 occlusion"
    if not readable(first, marking=True):
        return "R7 not readable at first"
    if not any(readable(look(k, v, open_cover(plan)), marking=True) for v in OTHER_VIEWS):
        return "R7 readable in one view only"
    return None


def partial(plan: Plan, look: Look) -> str | None:
    """Hidden within its third; the stratum's views and no others read the target."""
    k = _target(plan)
    assert k is not None
    first = look(k, FIRST_VIEW, first_cover(plan))
    low, high = plan.parts[k].hidden
    if not low <= 1.0 - first.share <= high:
        return "R7 occlusion"
    if not unreadable(first):
        return "R7 readable at first"
    reads = {v for v in OTHER_VIEWS if readable(look(k, v, open_cover(plan)), marking=True)}
    if reads != STRATA[plan.stratum]:
        return "R7 stratum"
    for other, _ in _others(plan, "near miss"):
        seen = look(other, FIRST_VIEW, first_cover(plan))
        if not unreadable(seen) or seen.share < NEAR_MISS_SHARE:
            return "R7 near-miss told apart at first"
    return None


STRATA: Final[dict[str, set[str]]] = {
    "right": {"right"},
    "close_high": {"close_high"},
    "both": {"right", "close_high"},
}


def covered(plan: Plan, look: Look) -> str | None:
    """Nothing of the target before the removal; the look after it reads it."""
    k = _target(plan)
    assert k is not None
    if look(k, FIRST_VIEW, "closed").share > 0.0:
        return "R7 seen under the lid"
    if not readable(look(k, FIRST_VIEW, "open"), marking=True):
        return "R7 not readable after removal"
    return None


def ambiguous(plan: Plan, look: Look) -> str | None:
    """Target and twin are read at first, unless under the lid or where identity is hidden."""
    for k, part in enumerate(plan.parts):
        if part.role not in ("target", "twin", "near miss"):
            continue
        under = plan.covered and part.relation == "inside"
        first = look(k, FIRST_VIEW, "open" if under else first_cover(plan))
        hidden = plan.identity_hidden and part.relation == plan.relation
        if hidden and (not unreadable(first) or first.share < NEAR_MISS_SHARE):
            return "R7 told apart at first"
        if part.role == "near miss":
            continue
        if not hidden and not (first.share >= TWIN_SHARE and readable(first, _marked(plan))):
            return "R7 not readable at first"
        sure = "right" if hidden else "close_high"
        if not readable(look(k, sure, open_cover(plan)), _marked(plan)):
            return f"R7 not readable from {sure}"
        if part.relation == "outside" and not confusable(
            first.over_container,
            look(k, "right", open_cover(plan)).over_container,
            look(k, "close_high", open_cover(plan)).over_container,
            plan.clear_right,
        ):
            return "R7 relation clear at first"
    return None


def confusable(first: float, right: float, above: float, clear_right: bool | None) -> bool:
    """Whether what stands outside seems to belong to the container where it is to seem so.

    Args:
        first: Share of its outline over the container in the first view.
        right: The same in the right view.
        above: The same from above, where the relation is always clear.
        clear_right: Whether the right view makes it clear; None: either way.
    """
    as_wanted = clear_right is None or (right <= CLEAR) == clear_right
    return first >= OVER and above <= CLEAR and as_wanted


def absent(plan: Plan, look: Look) -> str | None:
    """Every near-miss can be refuted from somewhere, and one at least not at first."""
    hard = False
    for k, part in _others(plan, "near miss"):
        marked = part.attributes.marking != plan.asked.marking
        under = plan.covered and part.relation == "inside"
        first = look(k, FIRST_VIEW, first_cover(plan))
        if not under and first.share < 0.4:
            return "R7 occlusion"
        if not any(readable(one, marked) for one in _all(plan, k, look)):
            return "R7 cannot be refuted"
        hard = hard or under or (marked and unreadable(first))
    return None if hard else "R7 all refuted at first"


FAMILY: Final[dict[str, Callable[[Plan, Look], str | None]]] = {
    "visible": visible,
    "partial": partial,
    "covered": covered,
    "ambiguous": ambiguous,
    "absent": absent,
}
