"""Bodies that touch are cut at their notches; single and hidden ones are left whole."""

import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.mask import Bits, iou
from surefetch.perception.silhouette import notched_share, split
from surefetch.perception.surface import Floats

SIZE = 160


def disc(x: int, y: int, radius: int) -> Bits:
    out = np.zeros((SIZE, SIZE), np.uint8)
    cv2.circle(out, (x, y), radius, 1, -1)
    return out > 0


def scene(*bodies: Bits) -> Floats:
    """Bodies half a metre away before a wall at one metre."""
    depth = np.full((SIZE, SIZE), 1.0, np.float32)
    for body in bodies:
        depth[body] = 0.5
    return depth


@settings(deadline=None, max_examples=40)
@given(st.integers(12, 40), st.integers(60, 100), st.integers(60, 100))
def test_a_convex_body_stays_whole(radius: int, x: int, y: int) -> None:
    body = disc(x, y, radius)
    assert len(split(body, scene(body))) == 1


@settings(deadline=None, max_examples=40)
@given(st.integers(16, 30), st.integers(16, 30), st.floats(0.0, 3.1))
def test_two_bodies_that_touch_become_two(r: int, s: int, angle: float) -> None:
    reach = 0.94 * (r + s)
    x, y = 80 + int(reach / 2 * np.cos(angle)), 80 + int(reach / 2 * np.sin(angle))
    a, b = disc(x, y, r), disc(160 - x, 160 - y, s) & ~disc(x, y, r)
    parts = split(a | b, scene(a, b))
    assert len(parts) == 2
    assert not (parts[0] & parts[1]).any()
    assert np.array_equal(parts[0] | parts[1], a | b)
    assert max(iou(parts[0], a), iou(parts[1], a)) > 0.85
    assert max(iou(parts[0], b), iou(parts[1], b)) > 0.85


def test_a_notch_made_by_something_nearer_is_no_notch() -> None:
    whole, nearer = disc(80, 80, 40), disc(80, 40, 22)
    body = whole & ~nearer
    assert notched_share(body, scene(body)) > 0.06
    depth = scene(whole)
    depth[nearer] = 0.4
    assert notched_share(body, depth) < 0.03
    assert len(split(body, depth)) == 1
