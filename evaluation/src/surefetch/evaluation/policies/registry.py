"""Every policy by its name, with the belief that it acts on."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib import import_module
from typing import Final

from surefetch.common.errors import BadInput
from surefetch.common.parameters import FULL
from surefetch.evaluation.fitting.variants import FACTORIZED, NO_MEMORY, POOLED_VIEWS
from surefetch.evaluation.policies import (
    actpermoma,
    introplan,
    pouct,
    roboexp,
    tampura,
    tuning,
)
from surefetch.evaluation.policies.actpermoma import ActPerMoMaLite, ActPerMoMaStrong
from surefetch.evaluation.policies.always_defer import AlwaysDefer
from surefetch.evaluation.policies.by_chance import ByChance
from surefetch.evaluation.policies.cheapest_first import CheapestFirst
from surefetch.evaluation.policies.dovsg import DovSgLite, DovSgStrong
from surefetch.evaluation.policies.exhaustive_look import ExhaustiveLook
from surefetch.evaluation.policies.fixed_sequence import BestFixed
from surefetch.evaluation.policies.greedy import Greedy
from surefetch.evaluation.policies.introplan import IntroPlan
from surefetch.evaluation.policies.introplan_chances import KNOWNO, LITE
from surefetch.evaluation.policies.observation import Policy
from surefetch.evaluation.policies.planned import Planned
from surefetch.evaluation.policies.pouct import Pouct
from surefetch.evaluation.policies.roboexp import RoboExpLite, RoboExpStrong
from surefetch.evaluation.policies.tampura import Tampura
from surefetch.evaluation.policies.tuning import THRESHOLDS, Scalar
from surefetch.planner.decide import HORIZON
from surefetch.planner.problem import Options

ORACLE: Final = "truth-oracle"
"""Knows the truth, and so is no policy: `replaying.oracle` plays it."""
HINDSIGHT: Final = "hindsight"
"""The best that looking could have come to: `replaying.hindsight` plays it."""
BOUNDS: Final = (ORACLE, HINDSIGHT)
"""Upper bounds, told by the truth."""
AT_LEAST: Final = 0.5
"""Belief from which the controls with a threshold grasp, where it was not tuned."""
HELD_OUT: Final = "held_out"
"""Argument of cross-fitted policies: scenes of which fold they must not have learned from."""
TAU: Final = Scalar("at_least", THRESHOLDS)


@dataclass(frozen=True)
class Entry:
    """How a policy is made, once for each episode, and on which belief it acts."""

    make: Callable[..., Policy]
    """Takes the scalars by name; each has a default."""
    variant: str = FULL
    scalars: tuple[Scalar, ...] = ()
    """What is tuned on development scenes, for each belief apart."""
    cross_fitted: bool = False
    """It learned from development scenes, and can be made without a share of them: `held_out`."""

    def having(self, **arguments: object) -> "Entry":
        """The same, made with these."""
        return replace(self, make=partial(self.make, **arguments))


def _planned(**switches: bool) -> Entry:
    return Entry(partial(Planned, Options(**switches)))


POLICIES: Final[dict[str, Entry]] = {
    "ours": _planned(),
    "paper-method": _planned(),
    "a1": Entry(partial(Planned, pooled_views=True), POOLED_VIEWS),
    "a2": Entry(Planned, NO_MEMORY),
    "a3": Entry(partial(Planned, Options(factorized=True)), FACTORIZED),
    "a4": _planned(hypothesis_independent_future=True),
    "a5": _planned(no_risk=True),
    "a6": _planned(no_conformal=True),
    "a7": _planned(no_defer=True),
    "a8": _planned(no_conformal=True, no_defer=True),
    "roboexp-lite": Entry(RoboExpLite),
    "roboexp-strong": Entry(RoboExpStrong, scalars=roboexp.SCALARS),
    "dovsg-lite": Entry(DovSgLite),
    "dovsg-strong": Entry(DovSgStrong, scalars=(TAU,)),
    "actpermoma-lite": Entry(ActPerMoMaLite),
    "actpermoma-strong": Entry(ActPerMoMaStrong, scalars=actpermoma.SCALARS),
    "exhaustive-look": Entry(partial(ExhaustiveLook, at_least=AT_LEAST), scalars=(TAU,)),
    "exhaustive-look-if-inside": Entry(
        partial(ExhaustiveLook, at_least=AT_LEAST, opens_for_outside=False), scalars=(TAU,)
    ),
    "best-fixed": Entry(BestFixed, scalars=(TAU,)),
    "cheapest-first": Entry(CheapestFirst),
    "greedy": Entry(Greedy),
    "greedy-threshold": Entry(partial(Greedy, at_least=AT_LEAST), scalars=(TAU,)),
    "introplan-strong": Entry(IntroPlan, scalars=introplan.SCALARS, cross_fitted=True),
    "introplan-lite": Entry(partial(IntroPlan, LITE), cross_fitted=True),
    "knowno": Entry(partial(IntroPlan, KNOWNO)),
    "tampura": Entry(Tampura, scalars=tampura.SCALARS),
    "tampura-undiscounted": Entry(
        partial(Tampura, discount=1.0, most_looks=HORIZON), scalars=tampura.SCALARS
    ),
    "pouct-lite": Entry(partial(Pouct, strong=False, gate=False), scalars=pouct.SCALARS),
    "pouct-strong": Entry(partial(Pouct, strong=True, gate=False), scalars=pouct.SCALARS),
    "pouct-lite-gated": Entry(partial(Pouct, strong=False, gate=True), scalars=pouct.SCALARS),
    "pouct-strong-gated": Entry(partial(Pouct, strong=True, gate=True), scalars=pouct.SCALARS),
    "always-defer": Entry(AlwaysDefer),
    "random": Entry(ByChance),
}


def tuned(word: str, profile: str) -> Entry:
    """The policy of this name, with what was tuned for the belief of this profile.

    Args:
        word: its name; may give scalars other values, ``NAME[SCALAR=VALUE;…]``.
        profile: whose belief it plays with.

    Raises:
        BadInput: there is none, or it has no such scalar; lists those that there are.
    """
    name, values = tuning.read_name(word)
    entry = find(name)
    known = {scalar.name for scalar in entry.scalars} | (
        {HELD_OUT} if entry.cross_fitted else set()
    )
    if unknown := sorted(set(values) - known):
        raise BadInput(
            f'the policy "{name}" has no scalar "{unknown[0]}".\n'
            f"  Scalars: {', '.join(sorted(known)) or 'none'}"
        )
    chosen = tuning.shipped(name, profile) if name in POLICIES else None
    return entry.having(**({} if chosen is None else chosen.arguments) | values)


def find(name: str) -> Entry:
    """The policy of this name, or of the user's own class, ``package.module:Class``.

    Raises:
        BadInput: there is none; lists those that there are.
    """
    if name in POLICIES:
        return POLICIES[name]
    module, colon, wanted = name.partition(":")
    if not colon:
        known = ", ".join([*POLICIES, *BOUNDS])
        raise BadInput(
            f'there is no policy "{name}".\n  Policies: {known},\n'
            "  or package.module:Class of your own."
        )
    try:
        made: Callable[[], Policy] = getattr(import_module(module), wanted)
    except (ImportError, AttributeError, ValueError) as error:
        raise BadInput(
            f'the policy "{name}" cannot be imported: {error}.\n'
            "  Is its package installed, and has the module this class?"
        ) from None
    return Entry(made)
