"""The world as perceived so far, from the looks of one episode. Pure.

Tracks come from the belief and are never forgotten. Container and obstacles are seen by some looks
and not by others, so the latest good reading of each is kept here.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import inverse, rigid, rotation_z
from surefetch.common.messages import (
    Box3d,
    ContainerReading,
    CoverState,
    Estimate,
    Observations,
    Track,
)
from surefetch.planner.actions import State

NO_POINTS: NDArray[np.float32] = np.zeros((0, 3), np.float32)
NOTHING_SEEN = Estimate(
    tracks=(), container=None, cover="unknown", obstacles=(), obstacle_points_world_m=NO_POINTS
)


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Container and obstacles, as the looks so far told."""

    container: ContainerReading | None = None
    obstacles: Mapping[str, tuple[Box3d, ...]] = field(default_factory=dict)
    """By viewpoint, from the latest look there."""
    points_world_m: NDArray[np.float32] = field(default_factory=lambda: NO_POINTS)
    """(n, 3) from the latest look alone: bodies that were moved since leave no ghosts."""

    def after(self, view: str | None, seen: Observations) -> "Surroundings":
        """With one more look."""
        return replace(
            self,
            container=_container(self.container, seen.container, seen.cover),
            obstacles={**self.obstacles, view or "": seen.obstacles},
            points_world_m=seen.obstacle_points_world_m,
        )


def estimate_of(tracks: Sequence[Track], around: Surroundings, cover: State) -> Estimate:
    """All that the executor may plan against.

    An obstacle that stands where a track or the container stands is that body, seen badly from
    another side, and is left out.
    """
    bodies = [track.solid for track in tracks if track.solid is not None]
    bodies += [around.container.outer] if around.container is not None else []
    seen = (box for boxes in around.obstacles.values() for box in boxes)
    return Estimate(
        tracks=tuple(tracks),
        container=_as_covered(around.container, cover),
        cover="unknown" if around.container is None else cover,
        obstacles=tuple(_others(seen, bodies)),
        obstacle_points_world_m=around.points_world_m,
    )


def _container(
    before: ContainerReading | None, now: ContainerReading | None, cover: CoverState
) -> ContainerReading | None:
    """The newest reading, but never one that the image border cuts in place of a whole one.

    The cover is always the newest that was seen.
    """
    if now is None or before is None or now.complete or not before.complete:
        return now or before
    lid = before.lid if cover == "unknown" else now.lid
    return msgspec.structs.replace(before, lid=lid)


def _as_covered(container: ContainerReading | None, cover: State) -> ContainerReading | None:
    """An open container has no lid, whatever an older reading said."""
    if container is None or cover == "covered":
        return container
    return msgspec.structs.replace(container, lid=None)


def _others(obstacles: Iterable[Box3d], bodies: Sequence[Box3d]) -> Iterable[Box3d]:
    return (box for box in obstacles if not any(_stands_in(box, body) for body in bodies))


def _stands_in(box: Box3d, body: Box3d) -> bool:
    """Whether the middle of a box lies within the footprint of a body."""
    T_world_body = rigid(rotation_z(body.yaw_rad), np.asarray(body.center_world_m))
    x, y, _ = (inverse(T_world_body) @ np.append(box.center_world_m, 1.0))[:3]
    return bool(abs(x) <= body.size_m[0] / 2.0 and abs(y) <= body.size_m[1] / 2.0)
