"""Detections and known tracks → all tracks after one look. Pure.

Nothing is ever forgotten: a track out of view stays as it was.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import msgspec

from surefetch.belief.association import Place, associate
from surefetch.common.messages import Detection, Track, Xyz


@dataclass(frozen=True, eq=False)
class Tracked:
    """All tracks, in order of age, and where each detection went."""

    tracks: tuple[Track, ...]
    track_of: tuple[int | None, ...]
    """For each detection the id of its track; None where it has no centre and was dropped."""


def track(detections: Sequence[Detection], tracks: Sequence[Track], step: int) -> Tracked:
    """Give every detection with a centre to its track, or make a new one of it.

    A track takes the newer detection's centre, extents and points, and its histogram if it has
    one. New tracks are numbered on, in the order of the detections, from 1.
    """
    placed = [(d, d.center_world_m) for d in detections]
    kept = [(d, center) for d, center in placed if center is not None]
    found = associate(
        [Place(center, d.hist) for d, center in kept],
        [Place(t.center_world_m, t.hist) for t in tracks],
    )
    newest = {t.id: t for t in tracks}
    track_of: dict[int, int] = {}
    for n, ((detection, center), index) in enumerate(zip(kept, found.track_of, strict=True)):
        if index is None:
            seen = _begin(max(newest, default=0) + 1, detection, center, step)
        else:
            seen = _refresh(tracks[index], detection, center, step)
        newest[seen.id] = seen
        track_of[n] = seen.id
    numbers = iter(range(len(kept)))
    ids = tuple(None if center is None else track_of[next(numbers)] for _, center in placed)
    return Tracked(tuple(newest.values()), ids)


def _begin(number: int, detection: Detection, center_world_m: Xyz, step: int) -> Track:
    return Track(
        id=number,
        center_world_m=center_world_m,
        solid=detection.solid,
        points_world_m=detection.points_world_m,
        hist=detection.hist,
        n_observations=0,
        y0=None,
        last_detection=detection.id,
        last_step=step,
    )


def _refresh(known: Track, detection: Detection, center_world_m: Xyz, step: int) -> Track:
    return msgspec.structs.replace(
        known,
        center_world_m=center_world_m,
        solid=detection.solid,
        points_world_m=detection.points_world_m,
        hist=known.hist if detection.hist is None else detection.hist,
        last_detection=detection.id,
        last_step=step,
    )
