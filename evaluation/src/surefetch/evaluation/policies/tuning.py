"""Which numbers of a policy are tuned, over which grid, and what tuning chose. Pure.

Every policy has the same budget: at most two numbers and fifty configurations, tried on
development scenes by `surefetch study tune`. What it chose ships as `tuned/NAME@PROFILE.json`, with
every configuration that was tried; each belief has a file of its own.

Source: EVALUATION, common interface and fairness rules.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Final

import msgspec

from surefetch.common.errors import BadInput
from surefetch.common.parameters import Provenance

MOST_SCALARS: Final = 2
MOST_CONFIGURATIONS: Final = 50

Values = Mapping[str, float]
"""By name of the scalar."""


@dataclass(frozen=True)
class Scalar:
    """A number that a policy takes by name, and the values of it that are tried."""

    name: str
    grid: tuple[float, ...]


THRESHOLDS: Final = (*(round(0.05 * n, 2) for n in range(1, 20)), 0.97, 0.99)
"""Of a belief."""


class TunedValue(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A frozen part of a file of tuned values."""


class Trial(TunedValue, frozen=True):
    """One configuration, and what came of it on all development scenes."""

    values: dict[str, float]
    n_successes: int
    by_family: dict[str, int]
    """Successes."""
    mean_realized_cost: float


class TunedOn(TunedValue, frozen=True):
    """Where tuned values come from."""

    scenes: Provenance
    parameters: str
    """Hash of the fitted numbers that belief and policy had."""
    outcomes: str
    """Of actions: measured or drawn."""
    command: str


class Tuned(TunedValue, frozen=True):
    """What tuning chose for one policy on one belief, and everything that it tried."""

    policy: str
    profile: str
    values: dict[str, float]
    trials: tuple[Trial, ...]
    """The ledger: every configuration, in the order of the grid."""
    tuned_on: TunedOn
    sequences: dict[str, tuple[str, ...]] | None = None
    """Of a policy that looks along fitted sequences: those, by what they are for."""
    sequence_successes: dict[str, dict[str, int]] | None = None
    """The ledger of these at the chosen values: successes of every sequence that was tried."""

    @property
    def arguments(self) -> dict[str, object]:
        """What the policy is made with."""
        fitted = {} if self.sequences is None else {"sequences": self.sequences}
        return {**self.values, **fitted}


def configurations(scalars: Sequence[Scalar]) -> list[dict[str, float]]:
    """Every combination of the grids, the last scalar changing fastest; one empty one of none.

    Raises:
        BadInput: more than the budget allows.
    """
    n = math.prod(len(scalar.grid) for scalar in scalars)
    if len(scalars) > MOST_SCALARS or n > MOST_CONFIGURATIONS:
        raise BadInput(
            f"{len(scalars)} numbers with {n} configurations are to be tuned "
            f"({', '.join(scalar.name for scalar in scalars)}); every policy has at most "
            f"{MOST_SCALARS} and {MOST_CONFIGURATIONS}."
        )
    names = [scalar.name for scalar in scalars]
    values = itertools.product(*(scalar.grid for scalar in scalars))
    return [dict(zip(names, row, strict=True)) for row in values]


def written(name: str, values: Mapping[str, float]) -> str:
    """A policy with values of its scalars, in one word: ``NAME[SCALAR=VALUE;SCALAR=VALUE]``."""
    if not values:
        return name
    return f"{name}[{';'.join(f'{key}={value:g}' for key, value in values.items())}]"


def read_name(word: str) -> tuple[str, dict[str, float]]:
    """The reverse of `written`; without brackets there are no values. Raises BadInput."""
    name, opened, rest = word.partition("[")
    if not opened:
        return name, {}
    try:
        pairs = [pair.split("=") for pair in rest.removesuffix("]").split(";")]
        return name, {key: float(value) for key, value in pairs}
    except ValueError:
        raise BadInput(f'"{word}": values of a policy are written NAME[SCALAR=VALUE;…].') from None


def best(trials: Sequence[Trial]) -> Trial:
    """The most successes; of equals the lowest mean realised cost, of equals again the first."""
    return min(trials, key=lambda trial: (-trial.n_successes, trial.mean_realized_cost))


@cache
def shipped(policy: str, profile: str) -> Tuned | None:
    """What ships for this policy on this belief; None where nothing was tuned."""
    path = f"tuned/{name_of(policy, profile)}"
    file = resources.files("surefetch.evaluation.policies").joinpath(path)
    return parse(file.read_bytes(), file.name) if file.is_file() else None


def name_of(policy: str, profile: str) -> str:
    """The file of a policy on a belief."""
    return f"{policy}@{profile}.json"


def parse(content: bytes, origin: str) -> Tuned:
    """Tuned values from JSON. Raises BadInput naming the file and the key."""
    try:
        return msgspec.json.decode(content, type=Tuned)
    except msgspec.DecodeError as error:
        raise BadInput(
            f"tuned values {origin}: {error}\n  Tune again: surefetch study tune"
        ) from None
