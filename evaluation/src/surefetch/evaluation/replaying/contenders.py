"""A policy, and the profile and numbers that it plays by."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput
from surefetch.common.messages import Target
from surefetch.common.parameters import FULL, PROFILES, Parameters
from surefetch.common.policies import OWN_PROFILE
from surefetch.evaluation.fitting import variants
from surefetch.evaluation.policies import registry, tuning
from surefetch.evaluation.policies.registry import Entry
from surefetch.planner import profiles
from surefetch.planner.profiles import Policy, Profile
from surefetch.planner.search import solve
from surefetch.planner.situation import Errand

WITH: Final = "@"


@dataclass(frozen=True, eq=False)
class Contender:
    """A policy with the profile and the numbers that it plays by."""

    label: str
    """As it was asked for: ``NAME`` or ``NAME@PROFILE``; NAME may carry values of its scalars."""
    name: str
    entry: Entry | None
    """None: an upper bound, which is no policy."""
    profile: Profile
    parameters: Parameters
    q_hat: float

    @property
    def variant(self) -> str:
        """Of the belief."""
        return FULL if self.entry is None else self.entry.variant

    @property
    def remembers(self) -> bool:
        """Whether its belief builds one look on those before."""
        return variants.remembers(self.variant)


def errand_of(one: Contender, target: Target, cell: Cell) -> Errand:
    """What the planner's own code is told of an errand, to carry out what a policy chose."""
    return Errand(target, "hold", Policy(one.name, one.profile, solve), one.parameters, cell)


def contender(label: str, profile: str, parameters: Mapping[str, Parameters]) -> Contender:
    """A policy by name, with the profile behind its ``@``, or else its own, or else this one.

    Raises:
        BadInput: there is no such policy or profile, the policy brings another profile, or its
            belief was not calibrated.
    """
    word, at, wanted = label.partition(WITH)
    name, _ = tuning.read_name(word)
    chosen = wanted if at else OWN_PROFILE.get(name, profile)
    if chosen not in PROFILES:
        raise BadInput(
            f'"{label}": there is no profile "{chosen}". Profiles: {", ".join(PROFILES)}'
        )
    if OWN_PROFILE.get(name, chosen) != chosen:
        raise BadInput(
            f'the policy "{name}" brings its own profile, {OWN_PROFILE[name]}; it cannot play '
            f'with "{chosen}". Name it without {WITH}{chosen}.'
        )
    numbers, rules = parameters[chosen], profiles.PROFILES[chosen]
    if name in registry.BOUNDS:
        return Contender(label, name, None, rules, numbers, numbers.q_hat())
    entry = registry.tuned(word, chosen)
    return Contender(label, name, entry, rules, numbers, numbers.q_hat(entry.variant))
