"""Beliefs as TAMPURA plans with them: concrete ones that looks change, and abstract ones. Pure.

Letters in shapes: N tracks, Y symbols, Z hypotheses (tracks by relation, then unobs, abs).

Source: Curtis et al., Partially Observable Task and Motion Planning with Uncertainty and Risk
Awareness (2024): belief-state abstraction.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import RELATIONS
from surefetch.planner.actions import N_CANDIDATES, State, compatible_with
from surefetch.planner.futures import Array
from surefetch.planner.problem import Problem

Standing = Literal["confirmed", "open", "refuted"]

REFUTED_BELOW: Final = 0.05
BINS: Final = (0.1, 0.5)
"""Edges between little, some and much mass of unobs and of abs."""
N_RELATIONS: Final = len(RELATIONS)


@dataclass(frozen=True, eq=False)
class Concrete:
    """What may be believed, and what was done."""

    masses: Array
    """(Z,) that sum to 1"""
    cover: State
    used: frozenset[str]


@dataclass(frozen=True)
class Abstract:
    """What is told apart of a belief."""

    standings: tuple[tuple[int, Standing], ...]
    """Of the three heaviest tracks, by place in the list of tracks, in that order."""
    unobs: int
    """Bin."""
    absent: int
    """Bin."""
    cover: State
    used: frozenset[str]


class Looks:
    """What comes of looks: the learned outcome model, E_fut with chances to remove and appear."""

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        n = len(problem.y0)
        self._up_to: dict[str, Array] = {}
        """(N, classes, Y), cumulative"""
        self._ratio: dict[str, Array] = {}
        """(N, Y, relations), against a distractor"""
        for row in problem.rows if n else ():
            E = np.array([problem.future.likelihood(row, y) for y in problem.y0])
            self._up_to[row.name] = E.cumsum(axis=-1)
            self._ratio[row.name] = (E[:, :-1] / E[:, -1:]).transpose(0, 2, 1)

    @property
    def root(self) -> Concrete:
        """What is believed now."""
        problem, belief = self._problem, self._problem.belief
        masses = np.array([*belief.p_tracked.ravel(), belief.p_unobs, belief.p_abs])
        return Concrete(masses / masses.sum(), problem.state, problem.used)

    def sample(self, at: Concrete, row: InformRow, rng: np.random.Generator) -> Concrete | None:
        """A belief after a look; None: the target appeared, which had no track."""
        problem = self._problem
        z = min(int((rng.random() > at.masses.cumsum()).sum()), len(at.masses) - 1)
        cover = at.cover
        if row.kind == "remove_cover" and rng.random() < problem.p_remove:
            cover = "open"
        appearing = problem.appears(row, cover)
        unobs = len(at.masses) - 2
        if z == unobs and rng.random() < appearing:
            return None
        masses = at.masses.copy()
        masses[unobs] *= 1.0 - appearing
        if problem.y0:
            masses[:unobs] *= self._seen(z, row, rng)
        return Concrete(masses / masses.sum(), cover, at.used | {row.name})

    def _seen(self, z: int, row: InformRow, rng: np.random.Generator) -> Array:
        """(Z - 2,) how much likelier each tracked hypothesis makes the symbols of all tracks."""
        n = len(self._problem.y0)
        classes = np.full(n, -1)
        if z < n * N_RELATIONS:
            classes[z // N_RELATIONS] = z % N_RELATIONS
        up_to = self._up_to[row.name][np.arange(n), classes]  # (N, Y)
        symbols = (rng.random((n, 1)) > up_to[:, :-1]).sum(axis=1)
        likelier: Array = self._ratio[row.name][np.arange(n), symbols].ravel()
        return likelier


def abstracted(at: Concrete, problem: Problem, confirmed_at: float) -> Abstract:
    """The abstract belief of a concrete one.

    Args:
        at: the concrete one.
        problem: says which relations the instruction allows.
        confirmed_at: least mass of a track, in a relation that it allows, to be confirmed.
    """
    p = at.masses[:-2].reshape(-1, N_RELATIONS)
    heaviest = np.argsort(-p.sum(axis=1), kind="stable")[:N_CANDIDATES]
    suiting = p[:, compatible_with(problem.asked)].max(axis=1)
    return Abstract(
        standings=tuple((int(i), _standing(suiting[i], confirmed_at)) for i in sorted(heaviest)),
        unobs=_bin(at.masses[-2]),
        absent=_bin(at.masses[-1]),
        cover=at.cover,
        used=at.used,
    )


def imagined(at: Abstract, row: InformRow) -> Iterator[Abstract]:
    """What a look might settle, at best: that one of the tracks is it, or that it is not there."""
    opens = row.kind == "remove_cover"
    after = replace(at, cover="open" if opens else at.cover, used=at.used | {row.name})
    refuted = tuple((i, _REFUTED) for i, _ in at.standings)
    for i, standing in at.standings:
        if standing != "refuted":
            settled = tuple((j, _CONFIRMED if j == i else _REFUTED) for j, _ in at.standings)
            yield replace(after, standings=settled, unobs=0, absent=0)
    yield replace(after, standings=refuted, unobs=0, absent=len(BINS))


_CONFIRMED: Final[Standing] = "confirmed"
_REFUTED: Final[Standing] = "refuted"


def _standing(p: float, confirmed_at: float) -> Standing:
    if p >= confirmed_at:
        return "confirmed"
    return "refuted" if p < REFUTED_BELOW else "open"


def _bin(p: float) -> int:
    return sum(p >= edge for edge in BINS)
