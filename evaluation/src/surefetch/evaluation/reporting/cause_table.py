"""Where failures come from, and success by how hidden the target is. Pure."""

from collections import Counter
from collections.abc import Mapping
from typing import Final, get_args

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.reporting import causes, names, numbers
from surefetch.evaluation.reporting.causes import Cause
from surefetch.evaluation.reporting.plan import Key
from surefetch.evaluation.reporting.scene_facts import Address, Facts
from surefetch.evaluation.reporting.study_results import Study
from surefetch.evaluation.reporting.table import Table

OCCLUSION: Final = (0.0, 0.15, 0.45, 0.6, 0.8, 0.95, 1.0)
"""Bounds of the strata; the last holds its upper bound."""

FactsOf = Mapping[Address, Facts]


def cause_table(study: Study, facts: FactsOf, key: Key) -> Table:
    """Failures of one policy by cause and family."""
    counts: dict[str, Counter[Cause]] = {family: Counter() for family in FAMILIES}
    for episode in study.played.get(key, ()):
        found = causes.cause(episode, facts[episode.family, episode.seed].known)
        if found is not None:
            counts[episode.family][found[0]] += 1
    rows = tuple(
        (
            cause,
            *(str(counts[f][cause]) for f in FAMILIES),
            str(sum(c[cause] for c in counts.values())),
        )
        for cause in get_args(Cause)
    )
    note = " ".join((causes.__doc__ or "").split("\n\n", 1)[1].split())
    title = f"Causes of failure, {names.of(key)}"
    return Table(title, ("cause", *FAMILIES, "all"), rows, (note,))


def by_occlusion(study: Study, facts: FactsOf, key: Key) -> list[tuple[str, int, int]]:
    """Successes and episodes by occlusion of the target at the first look; absent ones apart."""
    found = [(stratum(facts[e.family, e.seed]), e.verdict == "success") for e in study.played[key]]
    order = [*(_told(n) for n in range(len(OCCLUSION) - 1)), "no target"]
    return [
        (name, sum(won for s, won in found if s == name), sum(s == name for s, _ in found))
        for name in order
        if any(s == name for s, _ in found)
    ]


def stratum(facts: Facts) -> str:
    """The stratum of a scene."""
    hidden = facts.occlusion
    if hidden is None:
        return "no target"
    last = len(OCCLUSION) - 2
    return _told(max(n for n in range(last + 1) if n == 0 or hidden >= OCCLUSION[n]))


def strata_table(study: Study, facts: FactsOf, keys: list[Key]) -> Table:
    """Success by stratum and method."""
    each = {key: {s: (k, n) for s, k, n in by_occlusion(study, facts, key)} for key in keys}
    strata = list(dict.fromkeys(s for of in each.values() for s in of))
    rows = tuple((names.of(key), *(_cell(of.get(s)) for s in strata)) for key, of in each.items())
    note = "Occlusion of the target in the first look; 95–100 % are those under a cover, mostly."
    return Table("Success by occlusion at first", ("method", *strata), rows, (note,))


def _cell(counts: tuple[int, int] | None) -> str:
    k, n = counts or (0, 0)
    return f"{numbers.of(k, n)} {numbers.wilson_of(k, n)}" if n else numbers.of(k, n)


def _told(n: int) -> str:
    return f"{100 * OCCLUSION[n]:.0f}–{100 * OCCLUSION[n + 1]:.0f} %"
