"""What a policy is told before each of its actions, and what a policy is.

Nothing here comes from the scorer's files: no body, no pose, no family, no seed.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from surefetch.common.cell import Cell, InformRow
from surefetch.common.hypotheses import RELATIONS, Relation, tracked
from surefetch.common.messages import (
    AfterGrasp,
    BeliefReply,
    Choice,
    Estimate,
    Feasibility,
    Target,
)
from surefetch.common.parameters import Parameters
from surefetch.evaluation.recordings.free_space import FreeSpace, Grid, fused
from surefetch.planner import actions
from surefetch.planner.actions import State
from surefetch.planner.estimate import NOTHING_SEEN
from surefetch.planner.profiles import Profile
from surefetch.planner.situation import Situation

AFTER_GRASP: AfterGrasp = "hold"
"""A recording ends with the grasp."""


@dataclass(frozen=True)
class Grip:
    """A grasp that the instruction allows and the cover does not forbid, and its belief."""

    track: int
    relation: Relation
    p: float


@dataclass(frozen=True, eq=False)
class Observation:
    """Everything that a policy may know when it acts."""

    target: Target
    cell: Cell
    parameters: Parameters
    """Fitted numbers: emission, future emission, priors, chances of success."""
    profile: Profile
    """Failure rules."""
    believed: BeliefReply
    """Tracks, belief, conformal set and its threshold."""
    cover: State
    """As last verified by perception."""
    used: frozenset[str]
    """Information actions that gave their fresh observation."""
    given_up: frozenset[str]
    """Information actions that failed too often."""
    feasibility: Feasibility
    n_actions: int
    """Information actions and grasps executed so far, failed ones included."""
    rng: np.random.Generator
    """The policy's own random numbers; nobody else draws from them."""
    looks: tuple[FreeSpace, ...] = ()
    """What each look so far told of the space over the table, in order."""
    estimate: Estimate = NOTHING_SEEN
    """Container, obstacles and tracks, as the executor is told of them."""

    @cached_property
    def free_space(self) -> Grid:
        """(nx, ny, nz): what all looks so far tell together. See `recordings.free_space`."""
        return fused([look.grid() for look in self.looks])

    @property
    def situation(self) -> Situation:
        """The same as the planner takes it."""
        return Situation(self.believed, self.cover, self.used, self.given_up, self.feasibility)

    @property
    def informs(self) -> tuple[InformRow, ...]:
        """Information actions that are open now, in tie order."""
        out = self.used | self.given_up | self.situation.unreachable
        return actions.expandable(self.profile.rows(self.cell), self.cover, out)

    @property
    def grasps(self) -> tuple[Grip, ...]:
        """Grasps that are open now, the most probable first; the older track first of equals."""
        feasible = [v.track for v in self.feasibility.grasps if v.feasible]
        allowed = actions.graspable(self.target.relation, self.cover)
        belief = self.believed.belief
        found = [
            Grip(track, relation, belief[tracked(track, relation)])
            for track in sorted(feasible)
            for relation, suits in zip(RELATIONS, allowed, strict=True)
            if suits
        ]
        return tuple(sorted(found, key=lambda grip: -grip.p))


class Policy(Protocol):
    """One episode's decisions. A fresh one is made for each episode.

    A policy that explains itself keeps the words for its latest action in `because`.
    """

    def act(self, now: Observation, /) -> Choice | None:
        """The next action: one of `now.informs` or `now.grasps`, or to defer. None: no action."""
        ...


def words_of(policy: Policy) -> str:
    """Why the policy took its latest action; empty where it does not say."""
    because: object = getattr(policy, "because", "")
    return because if isinstance(because, str) else ""
