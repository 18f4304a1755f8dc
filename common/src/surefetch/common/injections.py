"""Failures that are only reported: an attempt is replaced by the word that it failed. Pure.

Nothing moves in its place, the state stays as it was, and no measured attempt is used up. They
belong to simulated episodes, replayed and live, and are addressed by family and seed.
"""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final, get_args

from surefetch.common.cell import Cell, InformRow
from surefetch.common.errors import BadInput
from surefetch.common.messages import Grasp, Inform, InjectedKind, Injection, Verb
from surefetch.common.streams import stream

KINDS: Final[tuple[InjectedKind, ...]] = get_args(InjectedKind)


def parse(word: str) -> Injection:
    """``KIND@K``, the K-th attempt of an episode, or ``KIND@0.P``, each with this chance.

    Raises:
        BadInput: says what there is.
    """
    kind, _, when = word.partition("@")
    if kind in KINDS and re.fullmatch(r"[1-9][0-9]?", when):
        return Injection(kind=kind, occurrence=int(when))
    if kind in KINDS and re.fullmatch(r"0\.[0-9]{1,4}|1\.0", when) and float(when) > 0.0:
        return Injection(kind=kind, rate=float(when))
    raise BadInput(
        f'"{word[:80]}" is no failure to inject. Name the kind and the attempt, counted from 1, '
        "or a rate:\n"
        f"  {', '.join(f'{kind}@1' for kind in KINDS)}, view@0.2"
    )


@dataclass(eq=False)
class Injector:
    """Counts the attempts of one episode."""

    family: str = ""
    seed: int = 0
    injections: tuple[Injection, ...] = ()
    _attempts: Counter[InjectedKind] = field(default_factory=Counter)

    def strikes(self, kind: InjectedKind) -> bool:
        """Whether the attempt that is due now is to be reported as failed instead."""
        self._attempts[kind] += 1
        n = self._attempts[kind]
        return any(self._is_meant(one, n) for one in self.injections if one.kind == kind)

    def _is_meant(self, one: Injection, n: int) -> bool:
        if one.occurrence is not None:
            return n == one.occurrence
        rng = stream(self.family, self.seed, "injection", one.kind, n)
        return float(rng.random()) < one.rate


def kind_of(verb: Verb, cell: Cell) -> InjectedKind | None:
    """What kind of attempt a command is; None: of none. Raises BadInput for an unknown action."""
    match verb:
        case Grasp():
            return "grasp"
        case Inform(name=name):
            return kind_of_action(cell.inform(name))
        case _:
            return None


def kind_of_action(row: InformRow) -> InjectedKind:
    """What kind of attempt an information action is."""
    return "cover" if row.kind == "remove_cover" else "view"


def told(injections: Iterable[Injection]) -> str:
    """In words that a command line takes, with commas between; empty for none."""
    return ",".join(map(str, injections))
