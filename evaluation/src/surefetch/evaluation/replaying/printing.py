"""Episodes to tables and to the JSON of `surefetch study evaluate`. Pure."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from rich.table import Table

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.running.metrics import (
    VERDICTS,
    by_family,
    failure_classes,
    row,
)

Episodes = Mapping[str, Sequence[EpisodeResult]]
MOST_LISTED: Final = 10


def plain(played: Episodes) -> dict[str, Any]:
    """As programs read it."""
    scored = {name: [e.scored for e in episodes] for name, episodes in played.items()}
    return {"policies": {name: {"families": by_family(of)} for name, of in scored.items()}}


def successes(played: Episodes) -> Table:
    """Success by family, each with its interval."""
    table = Table("policy", *FAMILIES, "all", title="Successes, % [95 % Wilson]")
    for name, episodes in played.items():
        scored = [e.scored for e in episodes]
        families = by_family(scored)
        shares = [_share(families[f]) if f in families else "-" for f in FAMILIES]
        table.add_row(name, *shares, _share(row(scored)))
    return table


def endings(played: Episodes) -> Table:
    """How often each class of ending came."""
    counts = {name: failure_classes([e.scored for e in of]) for name, of in played.items()}
    seen = [v for v in VERDICTS if any(count[v] for count in counts.values())]
    table = Table("policy", *(v.replace("_", " ") for v in seen), title="Endings")
    for name, count in counts.items():
        table.add_row(name, *(str(count[v]) for v in seen))
    return table


def efforts(played: Episodes) -> Table:
    """Means over the episodes."""
    table = Table("policy", "actions", "action cost", "realised cost", "planning", title="Means")
    for name, episodes in played.items():
        n = len(episodes)
        spent_s = [s for e in episodes for s in e.planning_s]
        table.add_row(
            name,
            f"{sum(e.n_actions for e in episodes) / n:.2f}",
            f"{sum(e.cost for e in episodes) / n:.3f}",
            f"{sum(e.realized_cost for e in episodes) / n:.3f}",
            f"{1e3 * sum(spent_s) / len(spent_s):.1f} ms" if spent_s else "-",
        )
    return table


def left(played: Episodes) -> Iterator[str]:
    """In words, which episodes the recordings do not hold to the end."""
    for name, episodes in played.items():
        aborted = [e for e in episodes if e.verdict == "aborted"]
        live = [e for e in episodes if e.finished_live]
        if live:
            yield f"{name} left the recording in {len(live)} episodes, which were finished live."
        if aborted:
            yield f"{name} left the recording in {len(aborted)} episodes, which count as aborted:"
        for e in aborted[:MOST_LISTED]:
            yield f"  {e.family}:{e.seed} after {', '.join(e.actions) or 'nothing'}: {e.why}"


def _share(cells: Mapping[str, Any]) -> str:
    low, high = cells["wilson_95"]
    share = cells["successes"] / cells["episodes"]
    return f"{100 * share:.0f} [{100 * low:.0f}, {100 * high:.0f}]"
