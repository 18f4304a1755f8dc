"""The rules of the two profiles, and the policies that live by them. Pure."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from surefetch.common import policies
from surefetch.common.cell import Cell, InformRow
from surefetch.planner.actions import N_CANDIDATES
from surefetch.planner.problem import Problem, Solution
from surefetch.planner.search import solve


@dataclass(frozen=True)
class Profile:
    """What may be done, what a failure means, and what is foreseen, in episodes and decisions."""

    name: str
    tries: int
    """Of one view, of one cover, of one target."""
    outlives_failure: bool
    """False: the first failed interaction ends the episode."""
    max_actions: int
    """Information actions and grasps that are executed, failed ones included."""
    views_while_covered: bool = False
    """Whether the camera may move before the cover is removed."""
    n_foreseen: int | None = None
    """How many tracks, the heaviest now, a look is foreseen to show one of; None: all."""
    defer_at_least: float = 0.0
    """Least belief in absence at which abstaining is open while there is something to look at."""

    def rows(self, cell: Cell) -> tuple[InformRow, ...]:
        """The information actions that these rules allow, in tie order."""
        return cell.rows(views_while_covered=self.views_while_covered)


@dataclass(frozen=True)
class Policy:
    """Which action to take, and under which rules."""

    name: str
    profile: Profile
    solve: Callable[[Problem], Solution]


PAPER: Final = Profile("paper", tries=1, outlives_failure=False, max_actions=6)
EXTENDED: Final = Profile(
    "extended",
    tries=3,
    outlives_failure=True,
    max_actions=12,
    views_while_covered=True,
    n_foreseen=N_CANDIDATES,
    defer_at_least=0.7,
)

PROFILES: Final = {profile.name: profile for profile in (PAPER, EXTENDED)}
POLICIES: Final = {
    name: Policy(name, PROFILES[profile], solve) for name, profile in policies.OWN_PROFILE.items()
}


def choose(profile: str, policy: str) -> Policy:
    """The policy of this name.

    Raises:
        BadInput: there is no such profile or policy, or the policy brings another profile.
    """
    policies.choose(profile, policy)
    return POLICIES[policy]
