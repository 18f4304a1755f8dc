"""How the episodes of every policy ended, in all and by family; classes sum to N. Pure."""

from typing import Final

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.reporting import names, numbers
from surefetch.evaluation.reporting.study_results import Episodes, Study
from surefetch.evaluation.reporting.table import Table
from surefetch.evaluation.running.metrics import VERDICTS, failure_classes

HEADS: Final = tuple(verdict.replace("_", " ") for verdict in VERDICTS)


def endings(study: Study) -> Table:
    """Of every policy."""
    rows = tuple((names.of(key), *_cells(of)) for key, of in study.played.items())
    return Table("How episodes ended", ("method", *HEADS, "N"), rows)


def endings_by_family(study: Study) -> Table:
    """Of every policy, family by family, with the interval of its successes."""
    rows = []
    for key, episodes in study.played.items():
        for family in FAMILIES:
            part = [e for e in episodes if e.family == family]
            won = sum(e.verdict == "success" for e in part)
            interval = numbers.wilson_of(won, len(part))
            rows.append((names.of(key), family, *_cells(part), interval))
    columns = ("method", "family", *HEADS, "N", "success, 95 % Wilson")
    return Table("How episodes ended, by family", columns, tuple(rows))


def _cells(episodes: Episodes) -> tuple[str, ...]:
    counts = failure_classes([e.scored for e in episodes])
    return (*(str(counts[verdict]) for verdict in VERDICTS), str(len(episodes)))
