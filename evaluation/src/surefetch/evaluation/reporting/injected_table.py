"""Failures that were only reported, and Table IV beside what is like it in simulation. Pure."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.reporting import names, numbers
from surefetch.evaluation.reporting.paper_numbers import PHYSICAL, PhysicalRow
from surefetch.evaluation.reporting.plan import OURS, PAPER_METHOD, Key
from surefetch.evaluation.reporting.study_results import Episodes, Study
from surefetch.evaluation.reporting.table import NA, Table

COLUMNS: Final = (
    "reported as failed", "method", "scenes", "struck", "success of struck", "95 % Wilson",
    "recovered of those that succeed without", "false defer", "wrong object", "extra actions",
    "duration s",
)  # fmt: skip
MARK: Final = "(failed, injected)"
WHO: Final = (PAPER_METHOD, OURS)


@dataclass(frozen=True, eq=False)
class Struck:
    """Episodes in which an injected report came, each with the same scene without."""

    kind: str
    """As it was asked for."""
    key: Key
    n_scenes: int
    with_it: Episodes
    without: Episodes
    """Same scenes in the same order; empty: not played."""

    @property
    def successes(self) -> int:
        """With the report."""
        return sum(e.verdict == "success" for e in self.with_it)

    @property
    def recovered(self) -> tuple[int, int]:
        """Successes among, and number of, episodes that succeed without the report."""
        both = zip(self.with_it, self.without, strict=True) if self.without else ()
        among = [hit.verdict == "success" for hit, other in both if other.verdict == "success"]
        return sum(among), len(among)


def struck(injected: Sequence[Study], others: Sequence[Study]) -> list[Struck]:
    """Of the paper's method and ours, in every folder with injected reports.

    Args:
        injected: folders with injected reports.
        others: folders without; the one on the same scenes is the comparison.
    """
    found = []
    for study in injected:
        same = next((one for one in others if set(one.scenes) >= set(study.scenes)), None)
        for key in WHO:
            if key in study.played:
                found.append(_struck(study, key, same))
    return found


def table(found: Sequence[Struck]) -> Table:
    """One row for each kind of report and method."""
    note = (
        "Struck: the report came in the episode. The paper: 5 of 5 grasp failures recovered, 0 of "
        "5 viewpoint failures, on the physical robot."
    )
    return Table("Injected failures", COLUMNS, tuple(map(_row, found)) or (_NO_ROW,), (note,))


def physical(study: Study, found: Sequence[Struck]) -> Table:
    """Table IV, with what is nearest to each condition in simulation."""
    rows = []
    for code, row in PHYSICAL.items():
        analogues = [_analogue(code, key, study, found) for key in WHO]
        rows.append((*_paper(row), *(cell for of in analogues for cell in of)))
    columns = ("condition", "paper, of 5", "paper s")
    ours = tuple(f"{names.short(k)}: {what}" for k in WHO for what in ("success", "95 %", "mean s"))
    note = (
        "No physical robot was used here: these are simulated analogues with modelled motion and "
        "perception times. Right: partial scenes that only the right view can settle; injected: "
        "the first report of its kind in an episode."
    )
    return Table(
        "Table IV. The paper's physical robot, beside a simulated analogue (no physical robot)",
        (*columns, *ours),
        tuple(rows),
        (note,),
    )


_NO_ROW: Final = (NA,) * len(COLUMNS)
_FITS: Final[Mapping[str, Callable[[EpisodeResult], bool]]] = {
    "visible": lambda e: e.family == "visible",
    "right": lambda e: (e.family, e.stratum) == ("partial", "right"),
    "covered": lambda e: e.family == "covered",
    "absent": lambda e: e.family == "absent",
}


def _struck(study: Study, key: Key, same: Study | None) -> Struck:
    hit = [e for e in study.played[key] if any(a.endswith(MARK) for a in e.actions)]
    other = {(e.family, e.seed): e for e in same.played.get(key, ())} if same is not None else {}
    kind = str(study.manifest.made_with.get("injected", ""))
    without = [other[e.family, e.seed] for e in hit] if other else []
    return Struck(kind, key, len(study.scenes), hit, without)


def _row(one: Struck) -> tuple[str, ...]:
    n = len(one.with_it)
    extra = [hit.n_actions - e.n_actions for hit, e in zip(one.with_it, one.without, strict=False)]
    again, could = one.recovered
    return (
        one.kind,
        names.of(one.key),
        str(one.n_scenes),
        str(n),
        numbers.of(one.successes, n),
        numbers.wilson_of(one.successes, n),
        f"{again}/{could} ({numbers.share(again, could)})" if could else NA,
        numbers.share(sum(e.verdict == "false_defer" for e in one.with_it), n),
        numbers.share(sum(e.verdict == "wrong_object" for e in one.with_it), n),
        numbers.mean(extra, 2),
        numbers.mean((e.duration_s for e in one.with_it), 1),
    )


def _paper(row: PhysicalRow) -> tuple[str, str, str]:
    return row.name, numbers.of(row.successes, row.n), str(row.mean_duration_s)


def _analogue(code: str, key: Key, study: Study, found: Sequence[Struck]) -> tuple[str, str, str]:
    episodes: Episodes
    if code in _FITS:
        episodes = [e for e in study.played.get(key, ()) if _FITS[code](e)]
    else:
        kinds = (one for one in found if one.kind == f"{code}@1" and one.key == key)
        episodes = next((one.with_it for one in kinds), ())
    k, n = sum(e.verdict == "success" for e in episodes), len(episodes)
    duration = numbers.mean((e.duration_s for e in episodes), 1)
    return numbers.of(k, n), numbers.wilson_of(k, n), duration
