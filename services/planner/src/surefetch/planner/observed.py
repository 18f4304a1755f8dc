"""What tracks become by what looks show of them, worked out once for all sets of looks. Pure.

Letters in shapes: N tracks that a look may show one of, Y symbols, R relations.
"""

from collections.abc import Mapping

import numpy as np

from surefetch.planner import rivals
from surefetch.planner.futures import Array
from surefetch.planner.rivals import Base, Entry, Ints, Stakes

Looks = tuple[str, ...]
"""Information actions that look at one track."""
Key = tuple[Looks, tuple[bool, ...], tuple[bool, ...]]


class Observed:
    """The tracks of one decision problem, as rivals see them."""

    def __init__(self, masses: Array, foreseen: Ints, ratios: Mapping[str, Array]) -> None:
        """Nothing is worked out yet.

        Args:
            masses: (tracks, R) of all tracks at the root.
            foreseen: (N,) places of those that a look may show one of, increasing.
            ratios: by information action, (N, Y, R), what their masses are multiplied by.
        """
        self.foreseen = foreseen
        self._masses = masses
        self._before = masses.sum(axis=1)
        self._ratios = ratios
        self._entries: dict[Key, Entry] = {}
        self._bases: dict[Key, Base] = {}

    def n_symbols(self, name: str) -> int:
        """Y of an information action."""
        return int(self._ratios[name].shape[1])

    def after(self, looks: Looks, stakes: Stakes) -> Entry:
        """(N, Y per look): each foreseen track after all of these looks at it."""
        key = (looks, stakes.compatible, stakes.graspable)
        if key not in self._entries:
            self._entries[key] = self._entry(looks, stakes)
        return self._entries[key]

    def base(self, stakes: Stakes) -> Base:
        """All tracks as they are at the root."""
        key = ((), stakes.compatible, stakes.graspable)
        if key not in self._bases:
            n = np.arange(len(self._masses))
            self._bases[key] = Base(rivals.entry(self._masses, self._before, n, stakes))
        return self._bases[key]

    def _entry(self, looks: Looks, stakes: Stakes) -> Entry:
        masses = self._masses[self.foreseen]
        for name in looks:
            ratio = self._ratios[name]
            between = (1,) * (masses.ndim - 2)
            masses = masses[..., None, :] * ratio.reshape(len(ratio), *between, *ratio.shape[1:])
        before = self._before[self.foreseen].reshape(-1, *(1,) * len(looks))
        return rivals.entry(masses, before, self.foreseen.reshape(before.shape), stakes)
