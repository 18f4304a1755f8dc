"""What the variables of an exported problem are called, and their values. Pure."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import OBSERVATIONS, RELATIONS
from surefetch.planner import actions
from surefetch.planner.actions import State
from surefetch.planner.problem import Problem

STATES: Final[tuple[State, ...]] = ("open", "covered")
NOT_YET: Final = "no"
USED: Final = "yes"
DONE: Final = "done"
NOTHING: Final = "none"
"""Observation where there was no look, or no track."""
DEFER: Final = "defer"

Case = tuple[str, ...]
"""A value of the cover, then one for each look whether it is used; ``*`` for any."""


@dataclass(frozen=True)
class Grip:
    """A grasp, as an action of the document."""

    track: int
    r: int
    """Of the relations."""
    column: int
    """Of the hypothesis under which it is right."""

    @property
    def name(self) -> str:
        return f"grasp_t{self.track}_{RELATIONS[self.r]}"


@dataclass(frozen=True)
class Words:
    """What the variables of the document are called, and their values."""

    rows: tuple[InformRow, ...]
    """Looks that are not used up."""
    grips: tuple[Grip, ...]
    hypotheses: tuple[str, ...]
    symbols: tuple[str, ...]
    looks: tuple[str, ...]
    """By how many were taken."""

    @classmethod
    def of(cls, problem: Problem) -> "Words":
        """The words of a problem."""
        tracks, suits = problem.belief.tracks, actions.compatible_with(problem.asked)
        return cls(
            rows=tuple(
                row for row in problem.rows if problem.horizon > 0 and row.name not in problem.used
            ),
            grips=tuple(
                Grip(track, r, n * len(RELATIONS) + r)
                for n, track in enumerate(tracks)
                for r in range(len(RELATIONS))
                if suits[r]
            ),
            hypotheses=(*(f"t{i}_{r}" for i in tracks for r in RELATIONS), "unobs", "abs"),
            symbols=(NOTHING, *(f"t{i}_{y}" for i in tracks for y in OBSERVATIONS)),
            looks=tuple(f"n{t}" for t in range(problem.horizon + 1)),
        )

    @property
    def observed(self) -> tuple[str, ...]:
        """The fully observed state before an action."""
        return ("looks_0", "cover_0", *(f"used_{row.name}_0" for row in self.rows))

    @property
    def ends(self) -> tuple[str, ...]:
        """Actions that end the episode."""
        return (*(grip.name for grip in self.grips), DEFER)

    @property
    def actions(self) -> tuple[str, ...]:
        return (*(row.name for row in self.rows), *self.ends)

    @property
    def anywhere(self) -> Case:
        return ("*",) * (1 + len(self.rows))

    def within(self, state: State) -> Case:
        """This cover, whatever is used."""
        return (state, *self.anywhere[1:])

    def cases(self, row: InformRow) -> Iterator[tuple[Case, bool]]:
        """All cases of one look, and whether it is open there."""
        yield from ((self.within(state), False) for state in STATES if state != row.requires)
        for value in (NOT_YET, USED):
            used = tuple(value if other == row else "*" for other in self.rows)
            yield (row.requires, *used), value == NOT_YET
