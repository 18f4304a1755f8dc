"""Markings are told by which pixels they explain; what can't be seen can't be told."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.geometry import Array
from surefetch.perception.answers.faces import Bools, Surfaces, lay
from surefetch.perception.answers.patches import patches
from surefetch.perception.answers.patterns import PLAIN, Explanation, explain, weights
from surefetch.perception.solids import Solid

FRONT_EYE = np.array([-0.55, 0.0, 0.42])
"""As the first view: it sees front and top."""
PX_M = 0.0012
MARKS = ("stripe", "dot", "cross")
BOX = Solid("box", 0.0, 0.0, 0.0, (0.05, 0.06), 0.0, 0.055, 0.3)
TALL = Solid("cylinder", 0.0, 0.0, 0.0, (0.05, 0.05), 0.0, 0.07, 0.3)


def seen(solid: Solid, eye: Array = FRONT_EYE) -> Surfaces:
    """The solid's pixels as a camera at the eye sees them, about 1.2 mm wide."""
    middle = np.array([solid.x_m, solid.y_m, 0.5 * (solid.base_m + solid.top_m)])
    across = np.cross(middle - eye, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    up = np.cross(across, middle - eye) / np.linalg.norm(middle - eye)
    steps = np.arange(-0.06, 0.06, PX_M)
    a, b = (part.reshape(-1, 1) for part in np.meshgrid(steps, steps))
    laid = lay(solid, middle - eye + a * across + b * up, eye)
    met = laid.met
    return Surfaces(
        solid,
        laid.hit[met],
        laid.met[met],
        laid.distance_m[met],
        laid.on_top[met],
        laid.side[met],
        laid.own_m[met],
        laid.cosine[met],
    )


def painted(kind: str, a: Array, b: Array, coverage: float) -> Bools:
    """A marking in coordinates of -1 … 1 on a rectangular face."""
    inside = (np.abs(a) <= 1.0) & (np.abs(b) <= 1.0)
    if kind == "stripe":
        return np.asarray(inside & (np.abs(b) < coverage))
    if kind == "dot":
        return np.asarray(inside & (np.hypot(a, b) < np.sqrt(4.0 * coverage / np.pi)))
    arm = 1.0 - np.sqrt(1.0 - coverage)
    return np.asarray(inside & ((np.abs(a) < arm) | (np.abs(b) < arm)))


def explained(marked: Bools, laid: Surfaces) -> dict[str, Explanation]:
    return explain(marked, weights(laid, 1.0), patches(laid, None), PX_M)


def told(found: dict[str, Explanation]) -> str:
    return min(found, key=lambda kind: found[kind].cost_px)


@settings(deadline=None, max_examples=40)
@given(st.sampled_from(MARKS), st.floats(0.3, 0.6), st.sampled_from(["front", "top"]))
def test_a_marking_on_a_box_is_told(kind: str, coverage: float, face: str) -> None:
    laid = seen(BOX)
    own = laid.own_m / [0.025, 0.03, 0.0275]
    if face == "front":
        marked = (laid.side == 2) & painted(kind, own[:, 1], own[:, 2], coverage)
    else:
        marked = laid.on_top & painted(kind, own[:, 1], own[:, 0], coverage)
    found = explained(np.asarray(marked), laid)
    assert told(found) == kind
    assert found[kind].face == face
    assert found[kind].cost_px < 0.2 * np.count_nonzero(marked)


@settings(deadline=None, max_examples=40)
@given(st.sampled_from(MARKS), st.floats(0.3, 0.6), st.floats(-0.26, 0.26))
def test_a_marking_on_a_cylinder_is_told_however_it_is_turned(
    kind: str, coverage: float, yaw: float
) -> None:
    laid = seen(TALL)
    across = (laid.azimuth_rad - np.pi - yaw + np.pi) % (2 * np.pi) - np.pi
    marked = ~laid.on_top & painted(kind, across / (np.pi / 4), laid.own_m[:, 2] / 0.035, coverage)
    assert told(explained(np.asarray(marked), laid)) == kind


def test_a_marking_that_may_be_turned_away_costs_no_more_than_none() -> None:
    laid = seen(BOX)
    found = explained(np.zeros(len(laid.met), dtype=np.bool_), laid)
    assert {found[kind].cost_px for kind in (PLAIN, *MARKS)} == {0.0}


def test_on_the_far_right_of_a_cylinder_a_dot_may_hide_and_a_stripe_shows_its_end() -> None:
    laid = seen(TALL)
    found = explained(np.zeros(len(laid.met), dtype=np.bool_), laid)
    assert found["dot"].cost_px < 2.0
    assert 10.0 < found["stripe"].cost_px < 40.0


def test_a_body_whose_marked_faces_are_all_in_view_is_plain_for_sure() -> None:
    laid = seen(BOX, np.array([-0.4, -0.4, 0.45]))
    found = explained(np.zeros(len(laid.met), dtype=np.bool_), laid)
    assert found[PLAIN].cost_px == 0.0
    assert min(found[kind].cost_px for kind in MARKS) > 40.0


@settings(deadline=None, max_examples=20)
@given(st.sampled_from(MARKS), st.randoms(use_true_random=False))
def test_the_order_of_pixels_changes_nothing(kind: str, random: object) -> None:
    laid = seen(BOX)
    marked = laid.on_top & painted(kind, laid.own_m[:, 1] / 0.03, laid.own_m[:, 0] / 0.025, 0.4)
    order = np.random.default_rng(random.randint(0, 99)).permutation(len(marked))  # type: ignore[attr-defined]
    shuffled = Surfaces(
        BOX,
        laid.hit[order],
        laid.met[order],
        laid.distance_m[order],
        laid.on_top[order],
        laid.side[order],
        laid.own_m[order],
        laid.cosine[order],
    )
    straight = explained(np.asarray(marked), laid)
    turned = explained(np.asarray(marked)[order], shuffled)
    for name, one in straight.items():
        assert turned[name].cost_px == pytest.approx(one.cost_px)


def test_what_is_seen_of_a_marking_is_the_cost_of_having_none() -> None:
    laid = seen(BOX)
    marked = np.asarray(laid.on_top & (np.abs(laid.own_m[:, 0]) < 0.01))
    assert explained(marked, laid)[PLAIN].cost_px == pytest.approx(np.count_nonzero(marked))
