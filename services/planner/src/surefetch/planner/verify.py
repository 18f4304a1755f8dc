"""Is an object gone from where it stood? A look tells, after the fingers said that they hold it.

Pure.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.geometry import inverse, project, transform
from surefetch.common.likeness import hellinger
from surefetch.common.messages import Box3d, Detection, FrameInfo, Track, Xyz

NEAR_M: Final = 0.04
"""So near to the old place a body still stands there: less than half the width of two objects."""
ALIKE: Final = 0.6
"""Hellinger distance of colours up to which two looks may show one body."""
SIZE_RATIO: Final = 1.6
"""Largest ratio of heights and of widths of one body seen twice; asked where colours are missing,
because a body that fell over keeps only those."""


@dataclass(frozen=True)
class PlaceCheck:
    """What a look at the old place says."""

    gone: bool | None
    """None: the place was not seen."""
    why: str


def look_at_place(
    track: Track,
    others: Sequence[Track],
    frame: FrameInfo,
    detections: Sequence[Detection],
    view: str | None,
) -> PlaceCheck:
    """Whether a track's body has left its place.

    Args:
        track: as it was before it was grasped.
        others: all other tracks; what stands in their places is them.
        frame: the new look.
        detections: what was perceived in it.
        view: the viewpoint from which the track was last seen; only from there is it sure that
            nothing hides its place.
    """
    if frame.view is None or frame.view != view or not _in_image(frame, track.center_world_m):
        return PlaceCheck(None, "its old place could not be seen again")
    there = [d for d in detections if d.center_world_m is not None and _is(d, track, others)]
    if there:
        return PlaceCheck(False, "a look shows it still in its old place")
    return PlaceCheck(True, "a look shows that it has left its old place")


def _is(detection: Detection, track: Track, others: Sequence[Track]) -> bool:
    """Whether a detection is this track's body, still in its place."""
    center = detection.center_world_m
    if center is None:
        return False
    apart_m = _apart_m(center, track.center_world_m)
    if apart_m > NEAR_M or any(_apart_m(center, o.center_world_m) < apart_m for o in others):
        return False
    if detection.hist is not None and track.hist is not None:
        return hellinger(detection.hist, track.hist) <= ALIKE
    return _of_one_size(detection.solid, track.solid)


def _of_one_size(a: Box3d | None, b: Box3d | None) -> bool:
    if a is None or b is None:
        return True
    height = _ratio(a.size_m[2], b.size_m[2])
    width = _ratio(max(a.size_m[:2]), max(b.size_m[:2]))
    return max(height, width) <= SIZE_RATIO


def _ratio(a_m: float, b_m: float) -> float:
    small, large = sorted((a_m, b_m))
    return large / small if small > 0.0 else np.inf


def _apart_m(a: Xyz, b: Xyz) -> float:
    return float(np.linalg.norm(np.subtract(a, b)))


def _in_image(frame: FrameInfo, p_world_m: Xyz) -> bool:
    p_camera_m = transform(inverse(frame.T_world_camera), np.array([p_world_m]))
    if p_camera_m[0, 2] <= 0.0:
        return False
    x, y = project(frame.K, p_camera_m)[0]
    return bool(0.0 <= x <= frame.width - 1 and 0.0 <= y <= frame.height - 1)
