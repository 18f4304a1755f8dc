"""The perception table counts what its definitions say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.evaluation.seeing import coco
from surefetch.evaluation.seeing import figures as perception_figures
from surefetch.evaluation.seeing import metrics as perception_metrics
from surefetch.evaluation.seeing.metrics import Bits, Found, Scored, count, f1, matched, share

SIZE = 24


def square(x: int, y: int, width: int = 6, height: int = 6) -> Bits:
    bits = np.zeros((SIZE, SIZE), dtype=np.bool_)
    bits[max(0, y) : y + height, max(0, x) : x + width] = True
    return bits


def found(bits: Bits, score: float = 1.0) -> Found:
    return Found(perception_metrics.box_of(bits), bits, score)


def picture(
    detections: list[Found] | None = None,
    objects: list[Found] | None = None,
    *,
    target: Found | None = None,
    container: Found | None = None,
    true_container: Found | None = None,
    ignored: tuple[Bits, ...] = (),
    layout: str = "visible:1",
    view: str = "center",
) -> Scored:
    return Scored(
        layout=layout,
        view=view,
        shape=(SIZE, SIZE),
        detections=tuple(detections or ()),
        objects=tuple(objects or ()),
        ignored=ignored,
        target=None if target is None else target.box,
        container=container,
        true_container=true_container,
    )


CORNERS, SIDES = st.integers(0, 18), st.integers(2, 6)
SQUARES = st.builds(square, CORNERS, CORNERS, SIDES, SIDES)
FINDS = st.lists(st.builds(found, SQUARES, st.floats(0.05, 1.0)), max_size=6).map(
    lambda some: sorted(some, key=lambda one: -one.score)
)
OBJECTS = st.lists(SQUARES.map(found), max_size=6)
PICTURES = st.lists(st.builds(picture, FINDS, OBJECTS), min_size=1, max_size=4)


@settings(deadline=None)
@given(FINDS, OBJECTS)
def test_matches_are_one_to_one_and_overlap_by_half(
    detections: list[Found], objects: list[Found]
) -> None:
    pairs = matched(detections, objects)
    assert len(set(pairs.values())) == len(pairs)
    for o, d in pairs.items():
        assert perception_metrics.box_iou(objects[o].box, detections[d].box) >= 0.5


def test_a_target_ranked_sixth_is_not_recalled() -> None:
    wanted = found(square(1, 1))
    others = [found(square(12, 2 * k), 0.9) for k in range(5)]
    late = found(square(1, 1), 0.1)
    assert share(count([picture([*others, late], target=wanted)]).target).n == 0
    assert share(count([picture([late, *others], target=wanted)]).target).n == 1


def test_pictures_without_a_visible_target_do_not_count_for_its_recall() -> None:
    assert share(count([picture([found(square(1, 1))])]).target).of == 0


def test_unmatched_objects_count_zero_in_one_mean_and_not_at_all_in_the_other() -> None:
    half = np.logical_and(square(1, 1), np.arange(SIZE)[None, :] < 5)
    counts = count([picture([found(half)], [found(square(1, 1)), found(square(15, 15))])])
    assert counts.ious == pytest.approx([4 / 6, 0.0])
    assert counts.matched_ious == pytest.approx([4 / 6])


def test_container_hits_misses_and_false_finds_make_its_f1() -> None:
    box, elsewhere = found(square(4, 4, 10, 8)), found(square(14, 14))
    hit = picture(container=box, true_container=box)
    wrong_place = picture(container=elsewhere, true_container=box)
    missed, made_up = picture(true_container=box), picture(container=box)
    assert f1(count([hit]).container_uncut) == 1.0
    assert f1(count([hit, missed]).container_uncut) == pytest.approx(2 / 3)
    assert f1(count([hit, made_up]).container_uncut) == pytest.approx(2 / 3)
    assert f1(count([hit, wrong_place]).container_uncut) == pytest.approx(2 / 4)
    assert np.isnan(f1(count([picture()]).container_uncut))


def test_containers_cut_by_the_border_are_counted_apart() -> None:
    cut = found(square(0, 4, 10, 8))
    counts = count([picture(container=cut, true_container=cut)])
    assert counts.container_cut["hit"] == 1
    assert not counts.container_uncut


@settings(deadline=None, max_examples=30)
@given(PICTURES)
def test_our_average_precision_is_that_of_the_library(pictures: list[Scored]) -> None:
    expected = coco.library_average_precision(pictures)
    ours = coco.average_precision(coco.matches(pictures))
    assert ours == pytest.approx(expected, nan_ok=True)


def test_finding_a_screen_or_a_scrap_costs_nothing_and_finding_nothing_there_does() -> None:
    thing, screen = square(1, 1), square(12, 12)
    pair = [found(screen, 0.9), found(thing, 0.5)]
    forgiven = picture(pair, [found(thing)], ignored=(screen,))
    punished = picture(pair, [found(thing)])
    assert coco.average_precision(coco.matches([forgiven])) == pytest.approx(1.0)
    assert coco.average_precision(coco.matches([punished])) < 0.6


def test_an_interval_resamples_layouts_and_not_pictures() -> None:
    values = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
    rng = np.random.default_rng(1)
    of_one = perception_metrics.interval(["a"] * 6, values, lambda v: float(np.mean(v)), rng)
    of_two = perception_metrics.interval(
        ["a"] * 3 + ["b"] * 3, values, lambda v: float(np.mean(v)), rng
    )
    assert of_one == (0.5, 0.5)
    assert of_two == (0.0, 1.0)


def test_figures_of_perfect_pictures_are_perfect_and_what_is_missing_is_none() -> None:
    one = found(square(2, 2))
    pictures = [picture([one], [one], target=one, view=view) for view in ("center", "right")]
    told = perception_figures.figures(pictures)
    assert sorted(told["views"]) == ["center", "right"]
    assert told["all"]["images"] == 2
    assert told["all"]["mask_ap_50_95"]["value"] == pytest.approx(1.0)
    assert told["all"]["target_recall_5"]["interval_95"] == (1.0, 1.0)
    assert told["all"]["container_f1_uncut"]["value"] is None
