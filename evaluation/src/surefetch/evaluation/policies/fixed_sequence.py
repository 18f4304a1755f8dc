"""Look along a sequence that was fixed beforehand, then grasp if sure enough."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from surefetch.common.messages import Choice, Inform
from surefetch.evaluation.policies.exhaustive_look import ExhaustiveLook
from surefetch.evaluation.policies.greedy import Greedy
from surefetch.evaluation.policies.observation import Observation, Policy

Sequence = tuple[str, ...]
"""Names of information actions."""


@dataclass(frozen=True)
class FixedSequence:
    """Leaves out what is not open when its turn comes."""

    sequence: Sequence
    at_least: float

    def act(self, now: Observation) -> Choice:
        """The next look of the sequence, and after the last the greedy end."""
        is_open = {row.name for row in now.informs}
        for name in self.sequence:
            if name in is_open:
                return Inform(name=name)
        return Greedy(self.at_least).act(now)


@dataclass
class BestFixed:
    """The one sequence that went best on development scenes with this cover and asked relation.

    Source: EVALUATION, controls.
    """

    at_least: float = 0.5
    sequences: Mapping[str, Sequence] = field(default_factory=dict)
    """By `situation_of`; where one is missing, everything is looked at."""
    _chosen: Policy | None = field(default=None, init=False)

    def act(self, now: Observation) -> Choice | None:
        """What the sequence says that was chosen at the first look."""
        if self._chosen is None:
            self._chosen = self._choose(situation_of(now.cover == "covered", now.target.relation))
        return self._chosen.act(now)

    def _choose(self, situation: str) -> Policy:
        if situation in self.sequences:
            return FixedSequence(self.sequences[situation], self.at_least)
        return ExhaustiveLook(self.at_least)


def situation_of(covered: bool, asked: str) -> str:
    """What a sequence is chosen for."""
    return f"{'covered' if covered else 'open'}, {asked} asked"
