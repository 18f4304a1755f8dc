"""Scored episodes to tables and to the JSON of `surefetch study evaluate`. Pure."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.running.metrics import (
    VERDICTS,
    Scored,
    by_family,
    failure_classes,
    realized_cost,
    row,
)

Scores = Mapping[str, Sequence[Scored]]


def plain(scored: Scores) -> dict[str, Any]:
    """As programs read it."""
    return {"policies": {name: {"families": by_family(eps)} for name, eps in scored.items()}}


def successes(scored: Scores) -> Table:
    """Success by family, each with its interval."""
    table = Table("policy", *FAMILIES, "all", title="Successes, % [95 % Wilson]")
    for name, episodes in scored.items():
        families = by_family(episodes)
        shares = [_share(families[f]) if f in families else "-" for f in FAMILIES]
        table.add_row(name, *shares, _share(row(episodes)))
    return table


def endings(scored: Scores) -> Table:
    """How often each class of ending came."""
    counts = {name: failure_classes(episodes) for name, episodes in scored.items()}
    seen = [v for v in VERDICTS if any(count[v] for count in counts.values())]
    table = Table("policy", *(v.replace("_", " ") for v in seen), title="Endings")
    for name, count in counts.items():
        table.add_row(name, *(str(count[v]) for v in seen))
    return table


def efforts(scored: Scores) -> Table:
    """Means over the episodes."""
    table = Table("policy", "actions", "action cost", "realised cost", title="Means")
    for name, episodes in scored.items():
        n = len(episodes)
        table.add_row(
            name,
            f"{sum(e.actions for e in episodes) / n:.2f}",
            f"{sum(e.cost for e in episodes) / n:.3f}",
            f"{sum(realized_cost(e) for e in episodes) / n:.3f}",
        )
    return table


def _share(cells: Mapping[str, Any]) -> str:
    low, high = cells["wilson_95"]
    share = cells["successes"] / cells["episodes"]
    return f"{100 * share:.0f} [{100 * low:.0f}, {100 * high:.0f}]"
