"""Table II: methods, each in blocks of their own. Pure."""

import statistics
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.reporting import names, numbers, plan
from surefetch.evaluation.reporting.comparisons import Comparison
from surefetch.evaluation.reporting.paper_numbers import BASELINES, PaperRow
from surefetch.evaluation.reporting.plan import ABLATIONS, LITE, OURS, PAPER_METHOD, STRONG, Key
from surefetch.evaluation.reporting.study_results import Episodes, Study
from surefetch.evaluation.reporting.table import NA, Table

HEADS: Final = tuple(family.capitalize() for family in FAMILIES)
PAPER_COLUMNS: Final = ("method", "N", *HEADS, "success", "95 % Wilson")
COLUMNS: Final = (
    "method", *HEADS, "success", "95 % Wilson", "wrong object", "false defer", "actions",
    "action cost", "realised cost", "duration s", "planning ms, median (95th)", "p (Holm)",
)  # fmt: skip
PROFILES: Final = ("paper", "extended")
HEAD: Final[tuple[Key, ...]] = (OURS, PAPER_METHOD)
LITE_KEYS: Final = (*HEAD, *((name, profile) for name in LITE for profile in ("paper",)))
STRONG_KEYS: Final = (*HEAD, *((name, profile) for profile in PROFILES for name in STRONG))
CONTROL_NAMES: Final = (
    *plan.LOOKERS, "exhaustive-look-if-inside", "best-fixed", "greedy", "greedy-threshold",
    "always-defer", "random",
)  # fmt: skip
BOUNDS: Final = ("truth-oracle", "hindsight")
NO_LLM: Final = (
    "(no LLM): the language model of this method is replaced by a rule; see the policy's file."
)


def blocks(
    headline: Study, paper_size: Study, comparisons: Mapping[Key, Comparison], size: str
) -> list[Table]:
    """The paper's numbers, then ours at the paper's size, then all.

    Args:
        headline: all results.
        paper_size: of the first scenes of each family.
        comparisons: by whom `ours` is compared to, those of the tests of success.
        size: what the size of `headline` may be called.
    """
    return [
        paper_block(),
        block(
            f"Table II b. Ours at the paper's size ({paper_size.per_family} per family): "
            "what 25 episodes can say",
            paper_size,
            _first_of(paper_size, (*HEAD, *_with(LITE), *_with(STRONG), *_loose(paper_size))),
            {},
        ),
        block(f"Table II c. Literal adaptations, {size}", headline, LITE_KEYS, {}, _with(LITE)),
        block(
            f"Table II d. Strong baselines, {size}",
            headline,
            STRONG_KEYS,
            comparisons,
            STRONG_KEYS,
        ),
        block(f"Table II e. Controls and bounds, {size}", headline, _loose(headline), {}),
        *_exploratory(headline, size),
    ]


def paper_block() -> Table:
    """What the paper prints."""
    rows = [(row.name, str(row.total[1]), *paper_cells(row)) for row in BASELINES.values()]
    return Table(
        "Table II a. The paper's own numbers (its episodes, simulator and perception, not ours)",
        PAPER_COLUMNS,
        tuple(rows),
        ("Never pooled with ours: scenes, simulator, perception and execution differ.",),
    )


def paper_cells(row: PaperRow) -> tuple[str, ...]:
    """By family, then success and interval."""
    k, n = row.total
    each = zip(row.successes, row.analyzed, strict=True)
    return (*(numbers.of(a, b) for a, b in each), numbers.share(k, n), numbers.wilson_of(k, n))


def block(
    title: str,
    study: Study,
    keys: Iterable[Key],
    comparisons: Mapping[Key, Comparison],
    expected: Sequence[Key] = (),
) -> Table:
    """One block: the policies that were played, and those that were expected and were not."""
    columns = COLUMNS if comparisons else COLUMNS[:-1]
    rows = []
    for key in dict.fromkeys(keys):
        episodes = study.played.get(key)
        if episodes is not None:
            row = (names.of(key), *cells(episodes), _p(comparisons.get(key)))
            rows.append(row[: len(columns)])
        elif key in expected:
            rows.append((names.of(key), *(NA,) * (len(columns) - 1)))
    notes = (NO_LLM,) if any("(no LLM)" in row[0] for row in rows) else ()
    return Table(title, columns, tuple(rows), notes)


def cells(episodes: Episodes) -> tuple[str, ...]:
    """Everything about one policy but its name and its test."""
    k, n = _successes(episodes), len(episodes)
    planning_s = [s for e in episodes for s in e.planning_s]
    median = numbers.milliseconds(planning_s, statistics.median)
    return (
        *family_cells(episodes),
        numbers.share(k, n),
        numbers.wilson_of(k, n),
        numbers.share(sum(e.verdict == "wrong_object" for e in episodes), n),
        numbers.share(sum(e.verdict == "false_defer" for e in episodes), n),
        numbers.mean((e.n_actions for e in episodes), 2),
        numbers.mean((e.cost for e in episodes), 3),
        numbers.mean((e.realized_cost for e in episodes), 3),
        numbers.mean((e.duration_s for e in episodes if e.steps), 1),
        f"{median} ({numbers.milliseconds(planning_s, numbers.p95)})" if planning_s else NA,
    )


def family_cells(episodes: Episodes) -> tuple[str, ...]:
    """Successes of episodes, by family."""
    parts = ([e for e in episodes if e.family == family] for family in FAMILIES)
    return tuple(numbers.of(_successes(part), len(part)) for part in parts)


def _successes(episodes: Episodes) -> int:
    return sum(episode.verdict == "success" for episode in episodes)


def _p(comparison: Comparison | None) -> str:
    return numbers.p_value(comparison.p_holm) if comparison is not None else NA


def _with(names_: Iterable[str]) -> tuple[Key, ...]:
    return tuple((name, "paper") for name in names_)


def _first_of(study: Study, keys: Iterable[Key]) -> list[Key]:
    return [key for key in keys if key in study.played]


def _loose(study: Study) -> list[Key]:
    """Controls and bounds that were played, with each belief."""
    wanted = (*CONTROL_NAMES, *BOUNDS)
    return [(n, p) for p in PROFILES for n in wanted if (n, p) in study.played]


def _exploratory(study: Study, size: str) -> list[Table]:
    """Whatever else was played; in no pre-declared group."""
    known = {"ours", "paper-method", *LITE, *STRONG, *ABLATIONS, *CONTROL_NAMES, *BOUNDS}
    others = [key for key in study.played if key[0] not in known]
    if not others:
        return []
    return [block(f"Table II f. Other policies, exploratory, {size}", study, others, {})]
