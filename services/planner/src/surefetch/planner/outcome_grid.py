"""All outcomes of a set of information actions at once: masses, and what grasping gains. Pure.

Every action of the set has shown one symbol of one track. Arrays over the set have two axes, track
and symbol, per action. Where several actions looked at the same track its mass changed more than
once, so outcomes are worked out by *pattern*: which actions share a track. The pattern in which all
tracks differ fills the array, the others overwrite where their tracks coincide.

Letters in shapes: N tracks that a look may show one of, Y symbols, R relations, k actions.
"""

import math
from collections.abc import Iterator
from functools import cached_property
from typing import Final

import numpy as np

from surefetch.planner import rivals
from surefetch.planner.futures import Array
from surefetch.planner.observed import Looks, Observed
from surefetch.planner.rivals import Base, Entry, Ints, Stakes

Pattern = tuple[tuple[int, ...], ...]
"""Actions by the track that they share, in order of their first."""

PATTERNS: Final[dict[int, tuple[Pattern, ...]]] = {
    0: ((),),
    1: (((0,),),),
    2: (((0,), (1,)), ((0, 1),)),
    3: (((0,), (1,), (2,)), ((0, 1), (2,)), ((0, 2), (1,)), ((0,), (1, 2)), ((0, 1, 2),)),
}
"""For each number of actions, the pattern without coincidences first."""

FEW: Final = 1 << 14
"""Outcomes up to which to look for those that may win costs more than to work out all."""


class OutcomeGrid:
    """The outcomes of one set of actions, seen from one rule of ending.

    `first` restricts the first action to some of the tracks that it may look at, so that a large
    set is worked out a piece at a time.
    """

    def __init__(
        self,
        observed: Observed,
        taken: Looks,
        total: float,
        stakes: Stakes,
        first: slice = slice(None),
    ) -> None:
        self._observed = observed
        self._taken = taken
        self._total = total
        self._stakes = stakes
        self._tracks = [np.arange(len(observed.foreseen)) for _ in taken]
        if taken:
            self._tracks[0] = self._tracks[0][first]

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """(N, Y) per action."""
        sizes = [
            (len(tracks), self._observed.n_symbols(name))
            for tracks, name in zip(self._tracks, self._taken, strict=True)
        ]
        return tuple(size for pair in sizes for size in pair)

    def mass(self) -> Array:
        """Total mass of every belief."""
        out = np.empty(self.shape)
        for pattern in PATTERNS[len(self._taken)]:
            entries = [self._entry(group) for group in pattern]
            self._put(out, pattern, sum((e.delta for e in entries), np.array(self._total)))
        return out

    def heaviest(self) -> Array:
        """Mass of the heaviest tracked hypothesis of every belief."""
        out = np.empty(self.shape)
        for pattern in PATTERNS[len(self._taken)]:
            entries = [self._entry(group) for group in pattern]
            mass = self._base.heaviest_without(*(self._track(group) for group in pattern))
            for entry in entries:
                mass = np.maximum(mass, entry.heaviest)
            self._put(out, pattern, mass)
        return out

    def gains(self, missing: float) -> Array:
        """What the best open grasp saves against the resort; `missing` where none is open."""
        distinct, *coinciding = PATTERNS[len(self._taken)]
        at_once = not coinciding or math.prod(self.shape) <= FEW
        out = self._gains_of(distinct, missing) if at_once else self._gains_apart(missing)
        for pattern in coinciding:
            self._put(out, pattern, self._gains_of(pattern, missing))
        return out

    def _gains_apart(self, missing: float) -> Array:
        """The gains where all tracks differ; what it makes of coincidences is meaningless."""
        out = np.full(self.shape, missing)
        *others, last = PATTERNS[len(self._taken)][0]
        n_symbols = self.shape[-1]
        entries = [self._entry(group) for group in others]
        mass = sum((entry.delta for entry in entries), np.array(self._total))
        for tracks, left_out in self._last_tracks():
            rest = self._base.without(*map(self._track, others), self._laid(left_out, last))
            for entry in entries[:-1]:
                rest = rest.join(entry)
            standing = rest.standing_with(entries[-1])
            rivals.write_gains_of_pairs(
                out.reshape(mass.size, -1),
                (tracks[:, None] * n_symbols + np.arange(n_symbols)).reshape(-1),
                mass.reshape(-1, 1),
                standing.map(lambda array: np.broadcast_to(array, mass.shape).reshape(-1, 1)),
                self._entry(last, tracks).map(lambda array: array.reshape(1, -1)),
                self._stakes,
            )
        return out

    def _last_tracks(self) -> Iterator[tuple[Ints, Ints]]:
        """Tracks that the last action may look at, with the one to leave out of all others.

        Each track whose absence the others feel comes alone; the rest come together, and may as
        well be left in.
        """
        tracks = self._tracks[-1]
        places = self._observed.foreseen[tracks]
        felt = np.isin(places, self._base.special(len(self._tracks) - 1))
        for k in np.flatnonzero(felt):
            yield tracks[k : k + 1], places[k : k + 1]
        if not felt.all():
            yield tracks[~felt], np.array([-1])

    def _gains_of(self, pattern: Pattern, missing: float) -> Array:
        """The gains where tracks coincide as in a pattern."""
        *others, last = pattern
        rest = self._base.without(*map(self._track, pattern))
        entries = [self._entry(group) for group in others]
        for entry in entries[:-1]:
            rest = rest.join(entry)
        standing = rest.standing_with(entries[-1]) if entries else rest.standing()
        mass = self._total + sum(
            (entry.delta for entry in entries), np.zeros((1,) * len(self.shape))
        )
        table = rivals.table(mass, standing, self._stakes)
        return rivals.gains(table, self._entry(last), self._stakes, missing)

    def _entry(self, group: tuple[int, ...], tracks: Ints | None = None) -> Entry:
        """What the track that these actions looked at has become, laid out on their axes."""
        looked_at = self._tracks[group[0]] if tracks is None else tracks
        axes = [1] * len(self.shape)
        axes[2 * group[0]] = len(looked_at)
        for action in group:
            axes[2 * action + 1] = self.shape[2 * action + 1]
        entry = self._observed.after(tuple(self._taken[k] for k in group), self._stakes)
        return entry.map(lambda array: array[looked_at].reshape(axes))

    def _track(self, group: tuple[int, ...]) -> Ints:
        return self._laid(self._observed.foreseen[self._tracks[group[0]]], group)

    def _laid(self, tracks: Ints, group: tuple[int, ...]) -> Ints:
        axes = [1] * len(self.shape)
        axes[2 * group[0]] = len(tracks)
        return tracks.reshape(axes)

    def _put(self, out: Array, pattern: Pattern, values: Array) -> None:
        """Write the outcomes of one pattern where they belong."""
        index: list[Ints] = [np.array(0)] * len(self.shape)
        for group in pattern:
            tracks = self._laid(self._tracks[group[0]], group)
            for action in group:
                symbols = [1] * len(self.shape)
                symbols[2 * action + 1] = -1
                start = self._tracks[action][0]
                index[2 * action] = tracks - start
                index[2 * action + 1] = np.arange(self.shape[2 * action + 1]).reshape(symbols)
        out[tuple(index)] = values

    @cached_property
    def _base(self) -> Base:
        return self._observed.base(self._stakes)
