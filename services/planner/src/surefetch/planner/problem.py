"""A decision to take, as one value, and the decision taken."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.joint_belief import JointBelief
from surefetch.common.messages import QValue
from surefetch.planner.actions import Costs, State, grasp_cost, heaviest
from surefetch.planner.futures import FutureModel

MAX_HORIZON: Final = 3


@dataclass(frozen=True)
class Options:
    """Ablations of the planner; with all off it is the full method.

    Source: golden cases, `options`.
    """

    factorized: bool = False
    hypothesis_independent_future: bool = False
    no_risk: bool = False
    no_conformal: bool = False
    no_defer: bool = False


@dataclass(frozen=True, eq=False)
class Problem:
    """Everything that a decision depends on."""

    belief: JointBelief
    y0: tuple[str | None, ...]
    """Latest counted observation of each track of the belief, None without any."""
    state: State
    used: frozenset[str]
    """Information actions that are out: used up, or infeasible now."""
    feasible: frozenset[int]
    """Tracks that the robot can grasp now."""
    asked: AskedRelation
    q_hat: float
    horizon: int
    """Information actions looked ahead, 0 to 3."""
    rows: tuple[InformRow, ...]
    """Information actions of the cell, in tie order."""
    future: FutureModel
    p_remove: float
    p_grasp: float
    costs: Costs = field(default_factory=Costs)
    options: Options = field(default_factory=Options)
    n_foreseen: int | None = None
    """How many tracks, the heaviest now, any look ahead is foreseen to show one of; None: all, as
    the paper."""
    defer_at_least: float = 0.0
    """Least belief in absence at which abstaining is open while there is something to look at."""
    commit_at_least: float = 0.0
    """Least belief in a hypothesis at which its object may be grasped, beside what the conformal
    set allows."""
    p_appears: Mapping[str, float] = field(default_factory=dict)
    """By information action: chance that it gives a target without a track its first one, where
    it does what it is to do; 0 for those that are missing."""

    def __post_init__(self) -> None:
        if not 0 <= self.horizon <= MAX_HORIZON:
            raise ValueError(f"horizon {self.horizon} is not between 0 and {MAX_HORIZON}")
        if len(self.y0) != len(self.belief.tracks):
            raise ValueError(
                f"{len(self.y0)} latest observations for {len(self.belief.tracks)} tracks"
            )

    @property
    def p_held(self) -> float:
        """The chance, as the costs see it, that grasping the right track succeeds."""
        return 1.0 if self.options.no_risk else self.p_grasp

    @property
    def foreseen(self) -> tuple[int, ...]:
        """Places of the tracks that a look may show one of, in order."""
        return tuple(sorted(heaviest(self.belief)[: self.n_foreseen]))

    @property
    def found_cost(self) -> float:
        """Cost of all that follows once the target has appeared: it is grasped for sure."""
        return grasp_cost(1.0, self.p_held, self.costs)

    def appears(self, row: InformRow, after: State) -> float:
        """Chance that a target without a track gets one; a cover that stays on shows nothing."""
        stays = row.kind == "remove_cover" and after == "covered"
        return 0.0 if stays else self.p_appears.get(row.name, 0.0)


@dataclass(frozen=True)
class Solution:
    """The value of every admissible root action, in tie order, and the one to take."""

    gamma: tuple[str, ...]
    q_values: tuple[QValue, ...]
    chosen: QValue | None
    """None: nothing is admissible."""
    value: float
    nodes: int
    """Decision nodes of the full enumeration; the search visits fewer."""
