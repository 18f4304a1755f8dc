"""Failures that are only reported: an attempt is replaced by the word that it failed. Pure.

Nothing moves in its place, the state stays as it was, and no measured attempt is used up.
"""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final, Literal, get_args

from surefetch.common.cell import InformRow
from surefetch.common.errors import BadInput
from surefetch.common.streams import stream

Kind = Literal["grasp", "view", "cover"]
KINDS: Final[tuple[Kind, ...]] = get_args(Kind)
EVERY_TIME: Final = 1.0


@dataclass(frozen=True)
class Injection:
    """One attempt of a kind, or each with some chance, is reported as failed."""

    kind: Kind
    occurrence: int | None = None
    """Counted from 1 within an episode; None: any, at the rate."""
    rate: float = EVERY_TIME

    def strikes(self, family: str, seed: int, n: int) -> bool:
        """Whether the n-th attempt of this kind in an episode is reported as failed."""
        if self.occurrence is not None:
            return n == self.occurrence
        return float(stream(family, seed, "injection", self.kind, n).random()) < self.rate

    def __str__(self) -> str:
        return f"{self.kind}@{self.rate if self.occurrence is None else self.occurrence}"


def parse(word: str) -> Injection:
    """``KIND@K``, the K-th attempt, or ``KIND@0.P``, each with this chance.

    Raises:
        BadInput: says what there is.
    """
    kind, _, when = word.partition("@")
    if kind in KINDS and re.fullmatch(r"[1-9][0-9]?", when):
        return Injection(kind, int(when))
    if kind in KINDS and re.fullmatch(r"0\.[0-9]{1,6}|1\.0", when) and float(when) > 0.0:
        return Injection(kind, rate=float(when))
    raise BadInput(
        f'"{word[:80]}" is no failure to inject. Name the kind and the attempt, counted from 1, '
        "or a rate:\n"
        f"  {', '.join(f'{kind}@1' for kind in KINDS)}, view@0.2"
    )


@dataclass(eq=False)
class Injector:
    """Counts the attempts of one episode."""

    family: str
    seed: int
    injections: tuple[Injection, ...] = ()
    _attempts: Counter[Kind] = field(default_factory=Counter)

    def strikes(self, kind: Kind) -> bool:
        """Whether the attempt that is made now is reported as failed."""
        self._attempts[kind] += 1
        return any(
            one.strikes(self.family, self.seed, self._attempts[kind])
            for one in self.injections
            if one.kind == kind
        )


def kind_of(row: InformRow) -> Kind:
    """The kind of an information action."""
    return "cover" if row.kind == "remove_cover" else "view"


def told(injections: Iterable[Injection]) -> str:
    """In words that a command line takes."""
    return ",".join(map(str, injections))
