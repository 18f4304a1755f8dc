"""Every segmenter keeps the port's promises."""

from collections.abc import Callable

import numpy as np
import pytest
from rendered import Shot, shoot
from tabletop import body, box, scene

from surefetch.common.mask import box_of, iou
from surefetch.perception.classical import classical_backend
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.ports import Segmenter


def classical() -> Segmenter:
    return classical_backend(LatestGeometry()).segmenter


SEGMENTERS: dict[str, Callable[[], Segmenter]] = {"classical": classical}


@pytest.fixture(scope="module")
def table() -> Shot:
    bodies = (body("a", at_m=(0.84, -0.15)), body("b", "ball", (0.05, 0.05, 0.048), (0.84, 0.15)))
    return shoot(scene(*bodies, container=box(covered=False)))


@pytest.mark.parametrize("name", sorted(SEGMENTERS))
def test_a_box_around_a_body_gives_the_body(name: str, table: Shot) -> None:
    truth = [table.pixels_of(k) for k in (0, 1, -2)]
    masks = SEGMENTERS[name]().segment(table.frame, [box_of(bits) for bits in truth])
    assert [iou(mask, bits) > 0.9 for mask, bits in zip(masks, truth, strict=True)] == [True] * 3


@pytest.mark.parametrize("name", sorted(SEGMENTERS))
def test_masks_come_in_the_order_of_the_boxes(name: str, table: Shot) -> None:
    boxes = [box_of(table.pixels_of(k)) for k in (0, 1, -2)]
    there = SEGMENTERS[name]().segment(table.frame, boxes)
    back = SEGMENTERS[name]().segment(table.frame, boxes[::-1])
    assert all(np.array_equal(a, b) for a, b in zip(there, back[::-1], strict=True))


@pytest.mark.parametrize("name", sorted(SEGMENTERS))
def test_masks_are_as_large_as_the_image_and_of_truth_values(name: str, table: Shot) -> None:
    (mask,) = SEGMENTERS[name]().segment(table.frame, [box_of(table.pixels_of(0))])
    assert mask.shape == table.segmentation.shape
    assert mask.dtype == np.bool_


@pytest.mark.parametrize("name", sorted(SEGMENTERS))
def test_no_boxes_give_no_masks(name: str, table: Shot) -> None:
    assert SEGMENTERS[name]().segment(table.frame, []) == ()
