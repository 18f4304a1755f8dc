"""Which looks an episode may have behind it, and what the robot then takes the world to be. Pure.

Tracks depend on the order of the looks, so a history is the states that were seen, in order. A
state that is seen again shows nothing new: it stands where it was seen first.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from surefetch.belief.tracking import track
from surefetch.common.cell import Cell
from surefetch.common.messages import Estimate, Observations, Track
from surefetch.evaluation.recordings.recording import Looks, paths, state_after, states
from surefetch.planner.actions import State as CoverNow
from surefetch.planner.estimate import Surroundings, estimate_of
from surefetch.planner.looks import cover_after


def histories(covered: bool, cell: Cell) -> list[Looks]:
    """Every history that can arise, each after its beginnings; then every state by itself.

    The latter are for a belief without memory, whose tracks are those of the latest look alone.
    """
    along = [
        looks_along(path, covered, cell) for path in paths(covered, cell, views_while_covered=True)
    ]
    alone = [(state,) for state in states(covered, cell)]
    return list(dict.fromkeys([*along, *alone]))


def looks_along(path: Sequence[str], covered: bool, cell: Cell) -> Looks:
    """What is seen along a sequence of information actions that succeed."""
    return tuple(state_after(path[:n], covered, cell) for n in range(len(path) + 1))


@dataclass(frozen=True, eq=False)
class Known:
    """The world as the looks of one history told it."""

    tracks: tuple[Track, ...] = ()
    around: Surroundings = field(default_factory=Surroundings)
    cover: CoverNow = "open"
    n_looks: int = 0

    def after(self, view: str, seen: Observations) -> "Known":
        """With one more look."""
        candidates = tuple(d for d in seen.detections if d.representative)
        return Known(
            tracks=track(candidates, self.tracks, self.n_looks).tracks,
            around=self.around.after(view, seen),
            cover=cover_after(self.cover, seen.cover),
            n_looks=self.n_looks + 1,
        )

    @property
    def estimate(self) -> Estimate:
        """All that the executor is told."""
        return estimate_of(self.tracks, self.around, self.cover)


def known_after(looks: Iterable[tuple[str, Observations]]) -> Known:
    """What is known after looks, each a view and what was seen from it."""
    known = Known()
    for view, seen in looks:
        known = known.after(view, seen)
    return known
