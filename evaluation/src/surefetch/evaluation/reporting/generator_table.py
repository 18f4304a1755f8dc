"""Table I: the paper's decision challenges, and what our generator makes of them. Pure."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.reporting import numbers
from surefetch.evaluation.reporting.paper_numbers import CHALLENGES
from surefetch.evaluation.reporting.scene_facts import Address, Facts
from surefetch.evaluation.reporting.study_results import Episodes, Study
from surefetch.evaluation.reporting.table import NA, Table

COLUMNS: Final = ("scenario", "family", "decision challenge (the paper's words)")
OURS: Final = (
    "scenes", "covered at first", "bodies", "near-misses", "twins", "target inside",
    "occlusion at first, mean", "accepted of attempts", "most frequent rejections",
)  # fmt: skip
MOST_REASONS: Final = 3


def table(study: Study, facts: Mapping[Address, Facts] | None) -> Table:
    """One row a family; means over the accepted scenes."""
    episodes = next(iter(study.played.values()))
    rows = []
    for family in FAMILIES:
        name, challenge = CHALLENGES[family]
        of = [e for e in episodes if e.family == family]
        cells = (NA,) * len(OURS)
        if facts is not None and of:
            cells = _cells(of, [facts[e.family, e.seed] for e in of])
        rows.append((name, family, challenge, *cells))
    note = "Scenes are rejected by geometry and visibility alone; no policy has a say."
    return Table("Table I. Scenarios", (*COLUMNS, *OURS), tuple(rows), (note,))


def rejections(facts: Mapping[Address, Facts]) -> Table:
    """All reasons for rejection, by family."""
    counts = {
        family: _rejected([f for (of, _), f in facts.items() if of == family])
        for family in FAMILIES
    }
    reasons = sorted({reason for count in counts.values() for reason in count})
    rows = tuple((reason, *(str(counts[f][reason]) for f in FAMILIES)) for reason in reasons)
    return Table("Attempts at scenes that were rejected", ("reason", *FAMILIES), rows)


def _cells(episodes: Episodes, facts: Sequence[Facts]) -> tuple[str, ...]:
    def mean(count: Callable[[Facts], int]) -> str:
        return numbers.mean((count(f) for f in facts), 1)

    n = len(facts)
    attempts = sum(f.scene.attempts for f in facts)
    rejected = _rejected(facts)
    hidden = [o for f in facts if (o := f.occlusion) is not None]
    inside = [f.scene.relation == "inside" for f in facts if f.scene.target is not None]
    return (
        str(n),
        numbers.share(sum(e.covered for e in episodes), n),
        mean(lambda f: len(f.recording.matches)),
        mean(lambda f: len(f.scene.near_misses)),
        mean(lambda f: len(f.scene.twins)),
        numbers.share(sum(inside), len(inside)),
        numbers.percent(sum(hidden) / len(hidden)) if hidden else NA,
        f"{n}/{attempts} ({numbers.share(n, attempts)})",
        ", ".join(f"{reason} {k}" for reason, k in rejected.most_common(MOST_REASONS)) or "none",
    )


def _rejected(facts: Sequence[Facts]) -> Counter[str]:
    counts: Counter[str] = Counter()
    for one in facts:
        counts.update(one.scene.rejected)
    return counts
