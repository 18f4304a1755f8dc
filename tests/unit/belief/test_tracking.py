"""Laws of tracks: nothing is forgotten, nothing is given twice, newer geometry wins."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.belief.tracking import Tracked, track
from surefetch.common.messages import Box3d, Detection, Mask, Track

RED, BLUE = (1.0, *([0.0] * 13)), (*([0.0] * 13), 1.0)
centers = st.tuples(st.floats(0.6, 1.2), st.floats(-0.3, 0.3), st.just(0.03))
hists = st.sampled_from([None, RED, BLUE])
Place = tuple[tuple[float, float, float] | None, tuple[float, ...] | None]
looks = st.lists(
    st.lists(st.tuples(st.none() | centers, hists), max_size=5), min_size=1, max_size=4
)


def detection(name: str, place: Place) -> Detection:
    center, hist = place
    return Detection(
        id=name,
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        phrase="thing",
        mask=Mask(height=1, width=1, counts=(1,)),
        group=0,
        representative=True,
        center_world_m=center,
        solid=None
        if center is None
        else Box3d(center_world_m=center, size_m=(0.05, 0.05, 0.05), yaw_rad=0.0),
        points_world_m=np.zeros((0, 3), np.float32),
        hist=hist,
        answers=None,
    )


def fold(seen: list[list[Place]]) -> list[tuple[list[Detection], Tracked]]:
    tracks: tuple[Track, ...] = ()
    done = []
    for step, places in enumerate(seen):
        detections = [detection(f"{step}-{i}", place) for i, place in enumerate(places)]
        tracked = track(detections, tracks, step)
        tracks = tracked.tracks
        done.append((detections, tracked))
    return done


@settings(deadline=None)
@given(looks)
def test_tracks_are_never_forgotten_and_stand_in_order_of_age(seen: list[list[Place]]) -> None:
    known: tuple[int, ...] = ()
    for _, tracked in fold(seen):
        ids = tuple(t.id for t in tracked.tracks)
        assert ids[: len(known)] == known
        assert ids == tuple(range(1, len(ids) + 1))
        known = ids


@settings(deadline=None)
@given(looks)
def test_every_detection_with_a_centre_has_a_track_of_its_own(seen: list[list[Place]]) -> None:
    for detections, tracked in fold(seen):
        given_to = [number for number in tracked.track_of if number is not None]
        assert len(set(given_to)) == len(given_to)
        for d, number in zip(detections, tracked.track_of, strict=True):
            assert (number is None) == (d.center_world_m is None)


@settings(deadline=None)
@given(looks)
def test_a_track_has_the_geometry_of_its_newest_detection(seen: list[list[Place]]) -> None:
    hist: dict[int, tuple[float, ...] | None] = {}
    for step, (detections, tracked) in enumerate(fold(seen)):
        by_id = {t.id: t for t in tracked.tracks}
        for d, number in zip(detections, tracked.track_of, strict=True):
            if number is None:
                continue
            newest = by_id[number]
            hist[number] = d.hist or hist.get(number)
            assert newest.center_world_m == d.center_world_m
            assert newest.solid == d.solid
            assert (newest.last_detection, newest.last_step) == (d.id, step)
            assert newest.hist == hist[number]


@settings(deadline=None)
@given(looks)
def test_tracks_out_of_view_stay_as_they_were(seen: list[list[Place]]) -> None:
    before: dict[int, Track] = {}
    for _, tracked in fold(seen):
        for t in tracked.tracks:
            if t.id not in tracked.track_of:
                assert t is before[t.id]
        before = {t.id: t for t in tracked.tracks}


def test_a_far_detection_and_one_of_another_colour_begin_tracks() -> None:
    near, far = (0.9, 0.0, 0.03), (0.9, 0.2, 0.03)
    (_, first), (_, second) = fold([[(near, RED)], [(far, RED), (near, BLUE)]])
    assert first.track_of == (1,)
    assert second.track_of == (2, 3)
