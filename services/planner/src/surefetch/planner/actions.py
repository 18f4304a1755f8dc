"""What may be done at a node, in tie order, and what it costs. Pure.

Information actions are rows of the cell file; none is named here.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import (
    ABS,
    NEEDS_OPEN,
    RELATIONS,
    AskedRelation,
    Relation,
    parse_tracked,
    tracked,
)
from surefetch.common.joint_belief import JointBelief

State = Literal["open", "covered"]

N_CANDIDATES = 3
"""Tracks considered for grasping."""


@dataclass(frozen=True)
class Costs:
    """Dimensionless costs of ending; those of information actions stand in the cell file.

    Source: paper, eq:terminal-costs.
    """

    grasp: float = 0.008
    failed_grasp: float = 0.5
    """Weight of the chance that the right object is grasped at and not held."""
    defer: float = 0.8
    """Weight of the chance that the target is there when the robot abstains."""
    stalled: float = 1.0
    """Of a node with nothing admissible."""

    def __post_init__(self) -> None:
        if self.defer >= 1.0 + self.grasp:
            raise ValueError("deferring must cost less than grasping what is surely wrong")


@dataclass(frozen=True)
class Candidate:
    """A track that may be worth grasping, in its likelier relation."""

    track: int
    relation: Relation
    p: float


def expandable(
    rows: tuple[InformRow, ...], state: State, used: frozenset[str]
) -> tuple[InformRow, ...]:
    """Information actions that are possible in this state and not used yet, in tie order."""
    return tuple(row for row in rows if row.requires == state and row.name not in used)


def transitions(row: InformRow, state: State, p_remove: float) -> tuple[tuple[State, float], ...]:
    """States after an information action, with their chances.

    Source: paper, eq:cover-transition.
    """
    if row.kind == "remove_cover":
        return (("open", p_remove), ("covered", 1.0 - p_remove))
    return ((state, 1.0),)


def graspable(asked: AskedRelation, state: State) -> tuple[bool, ...]:
    """For each relation, whether a track in it may be grasped: asked for, and within reach."""
    return tuple(
        compatible and (state == "open" or relation not in NEEDS_OPEN)
        for relation, compatible in zip(RELATIONS, compatible_with(asked), strict=True)
    )


def compatible_with(asked: AskedRelation) -> tuple[bool, ...]:
    """For each relation, whether the instruction allows it."""
    return tuple(asked in ("any", relation) for relation in RELATIONS)


def heaviest(belief: JointBelief) -> list[int]:
    """Places of the tracks by total mass, the heaviest and of equals the older first."""
    totals = belief.p_tracked.sum(axis=1)
    return sorted(range(len(totals)), key=lambda n: (-totals[n], n))


def candidates(belief: JointBelief, asked: AskedRelation, state: State) -> Iterator[Candidate]:
    """Grasps whose relation suits instruction and state, among the three heaviest tracks.

    Of equal relations the first counts.
    """
    allowed = graspable(asked, state)
    for n in heaviest(belief)[:N_CANDIDATES]:
        r = int(belief.p_tracked[n].argmax())
        if allowed[r]:
            yield Candidate(belief.tracks[n], RELATIONS[r], float(belief.p_tracked[n, r]))


def semantically_eligible(
    candidate: Candidate, gamma: tuple[str, ...], asked: AskedRelation, at_least: float = 0.0
) -> bool:
    """Whether the conformal set holds exactly one hypothesis that the instruction allows: this.

    Beside that, its belief must be `at_least` so much; 0 is the paper's rule.

    Source: paper, text below eq:conformal-set.
    """
    named = [parse_tracked(z) for z in gamma]
    allowed = [tracked(*z) for z in named if z is not None and asked in ("any", z[1])]
    alone = allowed == [tracked(candidate.track, candidate.relation)]
    return alone and candidate.p >= at_least


def may_defer(
    gamma: tuple[str, ...],
    informs: tuple[InformRow, ...],
    p_abs: float = 1.0,
    at_least: float = 0.0,
) -> bool:
    """Abstaining is open when nothing is left to look at, or the target is surely absent.

    For that it must be the only hypothesis in the conformal set, and its belief `at_least` so much;
    0 is the paper's rule.
    """
    return not informs or (gamma == (ABS,) and p_abs >= at_least)


P = TypeVar("P", float, NDArray[np.float64])


def grasp_cost(p: P, p_grasp: float, costs: Costs) -> P:
    """Q_grasp of a hypothesis with probability p. Source: paper, eq:terminal-costs."""
    return costs.grasp + (1.0 - p) + costs.failed_grasp * p * (1.0 - p_grasp)


def defer_cost(p_abs: P, costs: Costs) -> P:
    """Q_defer. Source: paper, eq:terminal-costs."""
    return costs.defer * (1.0 - p_abs)
