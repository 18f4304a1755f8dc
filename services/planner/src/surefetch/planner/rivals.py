"""When a grasp may end a leaf, for whole arrays of leaves at once. Pure.

Whether a grasp is open and what it saves against abstaining depends on little: the total mass,
the two heaviest hypotheses that the instruction allows, and the three heaviest tracks. A leaf
differs from the root in the few tracks that were observed on the way to it. So the untouched
tracks are summarised (`Rest`), one observed track after the other joins them, and for the last one
only thresholds on the total mass are left to compare (`Table`, `gains`).

All masses are unnormalised. -inf stands for "there is none".
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

NONE = -np.inf


@dataclass(frozen=True)
class Stakes:
    """The rule and the costs of ending, in one state.

    Grasping mass w of total W costs ``(1 + c)·W - kappa·w``. Against it stands a resort of
    ``resort·W - floor``: abstaining, or having nothing to do. The gain is the difference,
    ``kappa·w - floor - eta·W``.
    """

    share: float
    """1 - q̂: the share of the total mass that a hypothesis in the conformal set has at least"""
    conformal: bool
    least: float
    """Least share of the total mass at which a hypothesis may be grasped."""
    compatible: tuple[bool, ...]
    """For each relation, whether the instruction allows it."""
    graspable: tuple[bool, ...]
    """For each relation, whether a track in it may be grasped."""
    kappa: float
    eta: float
    resort: float
    floor: float
    optional: bool
    """Whether a leaf may take the resort even where a grasp is open."""

    def in_set_up_to(self, mass: Array) -> Array:
        """Total mass up to which a hypothesis of this mass is in the conformal set."""
        if self.share > 0.0:
            return mass / self.share
        return np.where(mass >= 0.0, np.inf, NONE)

    def open_up_to(self, mass: Array) -> Array:
        """Total mass up to which a hypothesis of this mass may be grasped."""
        upper = self.in_set_up_to(mass)
        return np.minimum(upper, mass / self.least) if self.least > 0.0 else upper

    def gains_up_to(self, mass: Array) -> Array:
        """Total mass up to which grasping this mass beats the resort."""
        return (self.kappa * mass - self.floor) / self.eta


@dataclass(frozen=True, eq=False)
class Arrays:
    """A bundle of arrays that broadcast against each other."""

    def map(self, change: Callable[[NDArray[np.generic]], NDArray[np.generic]]) -> Self:
        """The same bundle with one thing done to every array."""
        return type(self)(**{f.name: change(getattr(self, f.name)) for f in fields(self)})


@dataclass(frozen=True, eq=False)
class Entry(Arrays):
    """One observed track, for each of the outcomes it may have had."""

    age: Ints
    """Index of the track; lower is older."""
    delta: Array
    """Change of the total mass."""
    total: Array
    """Mass of the track."""
    first: Array
    """Heaviest hypothesis that the instruction allows."""
    second: Array
    """The next of them."""
    heaviest: Array
    """Heaviest hypothesis of all."""
    grasp: Array
    """Mass of the likelier relation if it may be grasped."""


def entry(masses: Array, before: Array, age: Ints, stakes: Stakes) -> Entry:
    """The entry of tracks with masses (…, relations), which had `before` (…) in all."""
    allowed = np.sort(masses[..., list(stakes.compatible)], axis=-1)
    likelier = masses.argmax(axis=-1)
    heaviest = masses.max(axis=-1)
    total = masses.sum(axis=-1)
    return Entry(
        age=np.broadcast_to(age, total.shape),
        delta=total - before,
        total=total,
        first=allowed[..., -1],
        second=allowed[..., -2] if allowed.shape[-1] > 1 else np.full_like(total, NONE),
        heaviest=heaviest,
        grasp=np.where(np.array(stakes.graspable)[likelier], heaviest, NONE),
    )


def outranks(total: Array, age: Ints, other: Array, other_age: Ints) -> Bools:
    """Whether one track comes before another: heavier, or as heavy and older."""
    before: Bools = (total > other) | ((total == other) & (age < other_age))
    return before


@dataclass(frozen=True, eq=False)
class Standing(Arrays):
    """What the last observed track finds: the rest with all others."""

    first: Array
    second: Array
    grasp_two: Array
    """Best grasp among the two heaviest tracks."""
    grasp_three: Array
    third: Array
    """Mass of the third heaviest track."""
    third_age: Ints


@dataclass(frozen=True, eq=False)
class Rest(Arrays):
    """The tracks so far, in short: their two heaviest hypotheses, their three heaviest tracks."""

    first: Array
    second: Array
    total_1: Array
    total_2: Array
    total_3: Array
    age_1: Ints
    age_2: Ints
    age_3: Ints
    grasp_1: Array
    grasp_2: Array
    grasp_3: Array

    def join(self, e: Entry) -> "Rest":
        """The rest with one more track."""
        o1 = outranks(e.total, e.age, self.total_1, self.age_1)
        o2 = outranks(e.total, e.age, self.total_2, self.age_2)
        o3 = outranks(e.total, e.age, self.total_3, self.age_3)
        return Rest(
            first=np.maximum(self.first, e.first),
            second=self._second_with(e),
            total_1=np.where(o1, e.total, self.total_1),
            total_2=np.where(o1, self.total_1, np.where(o2, e.total, self.total_2)),
            total_3=np.where(o2, self.total_2, np.where(o3, e.total, self.total_3)),
            age_1=np.where(o1, e.age, self.age_1),
            age_2=np.where(o1, self.age_1, np.where(o2, e.age, self.age_2)),
            age_3=np.where(o2, self.age_2, np.where(o3, e.age, self.age_3)),
            grasp_1=np.where(o1, e.grasp, self.grasp_1),
            grasp_2=np.where(o1, self.grasp_1, np.where(o2, e.grasp, self.grasp_2)),
            grasp_3=np.where(o2, self.grasp_2, np.where(o3, e.grasp, self.grasp_3)),
        )

    def standing(self) -> Standing:
        """What one more track finds."""
        two = np.maximum(self.grasp_1, self.grasp_2)
        return Standing(
            first=self.first,
            second=self.second,
            grasp_two=two,
            grasp_three=np.maximum(two, self.grasp_3),
            third=self.total_3,
            third_age=self.age_3,
        )

    def standing_with(self, e: Entry) -> Standing:
        """What one more track finds after this one: ``join(e).standing()`` with less work."""
        o2 = outranks(e.total, e.age, self.total_2, self.age_2)
        o3 = outranks(e.total, e.age, self.total_3, self.age_3)
        two = np.maximum(self.grasp_1, self.grasp_2)
        return Standing(
            first=np.maximum(self.first, e.first),
            second=self._second_with(e),
            grasp_two=np.where(o2, np.maximum(self.grasp_1, e.grasp), two),
            grasp_three=np.maximum(two, np.where(o3, e.grasp, self.grasp_3)),
            third=np.where(o2, self.total_2, np.where(o3, e.total, self.total_3)),
            third_age=np.where(o2, self.age_2, np.where(o3, e.age, self.age_3)),
        )

    def _second_with(self, e: Entry) -> Array:
        lesser = np.minimum(self.first, e.first)
        second: Array = np.maximum(lesser, np.maximum(self.second, e.second))
        return second


class Base:
    """The tracks as they are at the root, and what is left of them without a few."""

    def __init__(self, tracks: Entry) -> None:
        n = len(tracks.age)
        self._tracks = tracks
        self._by_total = np.lexsort((tracks.age, -tracks.total))
        both = np.concatenate([tracks.first, tracks.second])
        self._by_mass = np.argsort(-both, kind="stable")
        self._masses = both[self._by_mass]
        self._mass_owner = self._by_mass % n
        self._by_heaviest = np.argsort(-tracks.heaviest, kind="stable")

    def without(self, *excluded: Ints) -> Rest:
        """The rest when these tracks (indices that broadcast, -1 for none) are left out."""
        out = np.broadcast_arrays(*excluded)
        h = _first_kept(self._mass_owner, 2, 2, out)
        masses = np.append(self._masses, NONE)[h]
        n = _first_kept(self._by_total, 3, 1, out)
        k = np.append(self._by_total, len(self._by_total))[n]
        total = np.append(self._tracks.total, NONE)[k]
        grasp = np.append(self._tracks.grasp, NONE)[k]
        return Rest(
            masses[..., 0], masses[..., 1],
            total[..., 0], total[..., 1], total[..., 2],
            k[..., 0], k[..., 1], k[..., 2],
            grasp[..., 0], grasp[..., 1], grasp[..., 2],
        )  # fmt: skip

    def heaviest_without(self, *excluded: Ints) -> Array:
        """The heaviest hypothesis of all when these tracks are left out."""
        n = _first_kept(self._by_heaviest, 1, 1, np.broadcast_arrays(*excluded))
        by_rank: Array = np.append(self._tracks.heaviest[self._by_heaviest], NONE)
        return by_rank[n[..., 0]]

    def special(self, n_others: int) -> Ints:
        """Tracks whose absence can be felt in ``without`` when that leaves out n others too."""
        owners = self._mass_owner[np.sort(np.unique(self._mass_owner, return_index=True)[1])]
        return np.union1d(owners[: n_others + 2], self._by_total[: n_others + 3])


def _first_kept(order: Ints, wanted: int, each: int, excluded: tuple[Ints, ...]) -> Ints:
    """Positions in `order` of the first `wanted` items that belong to no excluded track.

    Each track has at most `each` items. ``len(order)`` stands for none.
    """
    reach = wanted + each * len(excluded)
    head = order[:reach]
    gone = np.zeros((*excluded[0].shape, len(head) + wanted), dtype=bool)
    for track in excluded:
        gone[..., : len(head)] |= head == track[..., None]
    position = np.concatenate([np.arange(len(head)), np.full(wanted, len(order))])
    kept: Ints = position[np.argsort(gone, axis=-1, kind="stable")[..., :wanted]]
    return kept


@dataclass(frozen=True, eq=False)
class Table:
    """Everything but the last observed track, with its thresholds worked out."""

    mass: Array
    """Total mass before the last track's change."""
    standing: Standing
    gain: Array
    """Gain of the best grasp at that total mass."""
    over: Array
    """The change must be above this, or two allowed hypotheses are in the conformal set."""
    beside: Array
    """The same when the grasp is on the last track."""
    up_to_two: Array
    """The change must be at most this for a grasp among the two heaviest tracks."""
    up_to_three: Array
    bumps: bool
    """Whether it matters anywhere that the last track ousts the third heaviest."""
    least_mass: float


def table(mass: Array, standing: Standing, stakes: Stakes) -> Table:
    """Thresholds for one more track to join."""
    s = standing
    upper = stakes.open_up_to(s.first)
    if stakes.optional:
        upper = np.minimum(upper, stakes.gains_up_to(s.first))
    upper = upper - mass
    up_to_three = np.where(s.grasp_three == s.first, upper, NONE)
    up_to_two = np.where(s.grasp_two == s.first, upper, NONE)
    return Table(
        mass=mass,
        standing=s,
        gain=stakes.kappa * s.first - stakes.floor - stakes.eta * mass,
        over=stakes.in_set_up_to(s.second) - mass,
        beside=stakes.in_set_up_to(s.first) - mass,
        up_to_two=up_to_two,
        up_to_three=up_to_three,
        bumps=bool((up_to_two != up_to_three).any()),
        least_mass=float(mass.min()),
    )


def gains(rest: Table, last: Entry, stakes: Stakes, missing: float) -> Array:
    """What grasping saves against the resort once the last track has joined.

    Args:
        rest: everything else.
        last: the last observed track; its arrays broadcast against the table's.
        stakes: rule and costs.
        missing: the value where no grasp is open (or, at an optional leaf, none saves).
    """
    if not stakes.conformal:
        return _gains_of_any(rest, last, stakes, missing)
    shape = np.broadcast_shapes(rest.gain.shape, last.delta.shape)
    out = np.full(shape, missing)
    wins = _rest_wins(rest, last, stakes)
    np.copyto(out, rest.gain - stakes.eta * last.delta, where=wins)
    np.copyto(out, _gain_of_last(rest, last, stakes), where=_last_wins(rest, last, stakes))
    return out


def write_gains_of_pairs(
    out: Array, at: Ints, mass: Array, standing: Standing, last: Entry, stakes: Stakes
) -> None:
    """`gains` of every row with every column, written only where a grasp may win.

    Args:
        out: (m, columns), filled with the value where no grasp is open.
        at: (q,), the columns to write to.
        mass: (m, 1), total mass before the last track's change.
        standing: what the last track finds, (m, 1).
        last: the last observed track's outcomes, (1, q).
        stakes: rule and costs.
    """
    rest = table(mass, standing, stakes)
    if not stakes.conformal:
        out[:, at] = _gains_of_any(rest, last, stakes, out[:, at])
        return
    upper = np.maximum(rest.up_to_two, rest.up_to_three)
    may_win = (upper > rest.over) & (upper >= last.delta.min()) & (rest.over < last.delta.max())
    rows = np.flatnonzero(may_win)
    if rows.size:
        some = table(mass[rows], standing.map(lambda array: array[rows]), stakes)
        of_row, of_column = np.nonzero(_rest_wins(some, last, stakes))
        gain = some.gain[of_row, 0] - stakes.eta * last.delta[0, of_column]
        out[rows[of_row], at[of_column]] = gain
    columns = np.flatnonzero(_last_up_to(last, stakes) >= rest.least_mass)
    if columns.size:
        few = last.map(lambda array: array[:, columns])
        of_row, of_column = np.nonzero(_last_wins(rest, few, stakes))
        gain = _gain_of_last(rest, few, stakes)[of_row, of_column]
        out[of_row, at[columns[of_column]]] = gain


def _rest_wins(rest: Table, last: Entry, stakes: Stakes) -> Bools:
    """Where the rest's heaviest hypothesis is alone in the conformal set and may be grasped."""
    upper = rest.up_to_three
    if rest.bumps:
        s = rest.standing
        ranks = outranks(last.total, last.age, s.third, s.third_age)
        upper = np.where(ranks, rest.up_to_two, rest.up_to_three)
    wins: Bools = last.delta <= upper
    wins = wins & (last.delta > rest.over)
    wins &= rest.mass > stakes.in_set_up_to(last.first) - last.delta
    return wins


def _last_wins(rest: Table, last: Entry, stakes: Stakes) -> Bools:
    """The same of the last track's own heaviest hypothesis."""
    s = rest.standing
    wins: Bools = outranks(last.total, last.age, s.third, s.third_age)
    wins = wins & (last.delta > rest.beside)
    wins &= rest.mass <= _last_up_to(last, stakes)
    wins &= rest.mass > stakes.in_set_up_to(last.second) - last.delta
    return wins


def _last_up_to(last: Entry, stakes: Stakes) -> Array:
    """Total mass before the last track's change up to which its hypothesis may win."""
    upper = stakes.open_up_to(last.first)
    if stakes.optional:
        upper = np.minimum(upper, stakes.gains_up_to(last.first))
    bound: Array = np.where(last.grasp == last.first, upper, NONE) - last.delta
    return bound


def _gain_of_last(rest: Table, last: Entry, stakes: Stakes) -> Array:
    own = stakes.kappa * last.first - stakes.floor - stakes.eta * last.delta
    gain: Array = own - stakes.eta * rest.mass
    return gain


def _gains_of_any(rest: Table, last: Entry, stakes: Stakes, missing: float | Array) -> Array:
    """`gains` without the conformal rule: the best of the three heaviest tracks."""
    s = rest.standing
    ranks = outranks(last.total, last.age, s.third, s.third_age)
    best = np.where(ranks, np.maximum(s.grasp_two, last.grasp), s.grasp_three)
    gain = stakes.kappa * best - stakes.floor - stakes.eta * (rest.mass + last.delta)
    open_ = gain > 0.0 if stakes.optional else best > NONE
    out: Array = np.where(open_, gain, missing)
    return out
