"""What a decision depends on: the errand, and the situation in which it is taken. Pure."""

from dataclasses import dataclass

from surefetch.common.cell import Cell, InformRow
from surefetch.common.messages import AfterGrasp, BeliefReply, Feasibility, Target
from surefetch.common.parameters import Parameters
from surefetch.planner.actions import State
from surefetch.planner.profiles import Policy


@dataclass(frozen=True, eq=False)
class Errand:
    """What is to be fetched, and by which rules and numbers."""

    target: Target
    after_grasp: AfterGrasp
    policy: Policy
    parameters: Parameters
    cell: Cell

    @property
    def rows(self) -> tuple[InformRow, ...]:
        """The information actions that may be taken at all, in tie order."""
        return self.policy.profile.rows(self.cell)


@dataclass(frozen=True, eq=False)
class Situation:
    """Everything that a decision depends on, beside the errand."""

    believed: BeliefReply
    cover: State
    used: frozenset[str]
    """Information actions that gave their fresh observation."""
    given_up: frozenset[str]
    """Information actions that failed too often."""
    feasibility: Feasibility

    @property
    def unreachable(self) -> frozenset[str]:
        """Information actions that the robot cannot do now."""
        return frozenset(v.name for v in self.feasibility.informs if not v.feasible)
