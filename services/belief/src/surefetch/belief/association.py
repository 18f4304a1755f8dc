"""Which detection is which known track. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from surefetch.common.likeness import hellinger
from surefetch.common.messages import Xyz

Array = NDArray[np.float64]

GATE_M: Final = 0.12
"""Farther apart, two centres are two objects."""
UNMATCHED: Final = 1.0
"""Cost of a new track; a match costs less."""
_NEVER: Final = 1e3


@dataclass(frozen=True)
class Place:
    """What association looks at: where a body's centre is, and its colours."""

    center_world_m: Xyz
    hist: tuple[float, ...] | None
    """14 bins that sum to 1, None when unavailable."""


@dataclass(frozen=True, eq=False)
class Assignment:
    """For each detection its track, by index, or None for a new one."""

    track_of: tuple[int | None, ...]
    cost: Array
    """(detections, tracks), +inf for a pair that may not match"""

    @property
    def total(self) -> float:
        """Cost of the matches, plus 1 for each new track."""
        return sum(
            UNMATCHED if track is None else float(self.cost[detection, track])
            for detection, track in enumerate(self.track_of)
        )


def associate(detections: Sequence[Place], tracks: Sequence[Place]) -> Assignment:
    """Match each detection to the track it most likely came from.

    Minimises the summed cost: distance over 0.12 m plus the Hellinger distance of the histograms,
    and 1 for each detection that starts a new track. No track is used twice.

    Source: paper, C_assoc; Kuhn, The Hungarian Method for the Assignment Problem (1955).
    """
    n_detections, n_tracks = len(detections), len(tracks)
    cost = np.array(
        [[pair_cost(d, t) for t in tracks] for d in detections], dtype=np.float64
    ).reshape(n_detections, n_tracks)
    fresh = np.full((n_detections, n_detections), UNMATCHED)
    table = np.hstack([np.where(np.isinf(cost), _NEVER, cost), fresh])
    _, columns = linear_sum_assignment(table)
    return Assignment(tuple(int(j) if j < n_tracks else None for j in columns), cost)


def pair_cost(detection: Place, track: Place) -> float:
    """C_assoc of one pair; +inf when it may not match."""
    apart_m = float(np.linalg.norm(np.subtract(detection.center_world_m, track.center_world_m)))
    cost = apart_m / GATE_M + hellinger(detection.hist, track.hist)
    return cost if apart_m <= GATE_M and cost < UNMATCHED else float("inf")
