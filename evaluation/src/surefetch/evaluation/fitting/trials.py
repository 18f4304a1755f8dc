"""Execution trials to chances of success. Pure.

A group is one action on one scene; it succeeds only if all its attempts do.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from surefetch.common.cell import Cell


@dataclass(frozen=True)
class Attempt:
    """One executed action of a development episode."""

    scene: str
    action: str
    succeeded: bool


def groups(attempts: Iterable[Attempt], actions: frozenset[str]) -> tuple[int, int]:
    """Successful groups and all groups of these actions."""
    together: dict[tuple[str, str], bool] = {}
    for attempt in attempts:
        if attempt.action in actions:
            key = attempt.scene, attempt.action
            together[key] = together.get(key, True) and attempt.succeeded
    return sum(together.values()), len(together)


def chance(successes: int, trials: int) -> float:
    """The expected rate after a Beta(1, 1) prior. Source: text above eq:terminal-costs."""
    return (successes + 1) / (trials + 2)


def removals(cell: Cell) -> frozenset[str]:
    """Names of the actions that take a cover off."""
    return frozenset(row.name for row in cell.informs if row.kind == "remove_cover")
