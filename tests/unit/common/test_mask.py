"""Masks are COCO's run lengths, and overlaps are symmetric."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from pycocotools import mask as coco

from surefetch.common import mask
from surefetch.common.mask import Bits
from surefetch.common.messages import Mask

SHAPES = st.tuples(st.integers(1, 12), st.integers(1, 12))


def bits() -> st.SearchStrategy[Bits]:
    return hnp.arrays(np.bool_, SHAPES)


def pairs() -> st.SearchStrategy[tuple[Bits, Bits]]:
    return SHAPES.flatmap(
        lambda shape: st.tuples(hnp.arrays(np.bool_, shape), hnp.arrays(np.bool_, shape))
    )


@settings(deadline=None)
@given(bits())
def test_a_mask_comes_back_from_its_run_lengths(image: Bits) -> None:
    assert np.array_equal(mask.decode(mask.encode(image)), image)


@settings(deadline=None)
@given(bits())
def test_run_lengths_are_those_of_coco(image: Bits) -> None:
    ours = mask.encode(image)
    uncompressed = {"size": [ours.height, ours.width], "counts": list(ours.counts)}
    theirs = coco.frPyObjects(uncompressed, ours.height, ours.width)
    assert theirs["counts"] == coco.encode(np.asfortranarray(image.astype(np.uint8)))["counts"]


def test_run_lengths_that_do_not_fill_the_image_are_refused() -> None:
    with pytest.raises(ValueError, match="runs add up to 5, an image of 3 x 2"):
        mask.decode(Mask(height=2, width=3, counts=(2, 3)))


@settings(deadline=None)
@given(pairs())
def test_overlap_is_symmetric_bounded_and_equal_to_the_matrix(pair: tuple[Bits, Bits]) -> None:
    a, b = pair
    assert mask.iou(a, b) == mask.iou(b, a)
    assert 0.0 <= mask.iou(a, b) <= 1.0
    assert mask.iou(a, a) == (1.0 if a.any() else 0.0)
    assert mask.iou_matrix([a], [b])[0, 0] == pytest.approx(mask.iou(a, b), abs=1e-6)


@settings(deadline=None)
@given(bits())
def test_the_box_is_the_smallest_that_holds_all_pixels(image: Bits) -> None:
    x0, y0, x1, y1 = (int(v) for v in mask.box_of(image))
    inside = image[y0:y1, x0:x1]
    assert inside.sum() == image.sum()
    if image.any():
        assert inside[0].any() and inside[-1].any()
        assert inside[:, 0].any() and inside[:, -1].any()


def test_boxes_that_only_touch_do_not_overlap() -> None:
    assert mask.box_iou((0, 0, 2, 2), (2, 0, 4, 2)) == 0.0
    assert mask.box_iou((0, 0, 2, 2), (0, 1, 2, 3)) == pytest.approx(1 / 3)
    assert mask.box_iou((0, 0, 0, 0), (0, 0, 0, 0)) == 0.0
