"""Table III: the full method and what is left when one thing is taken out. Pure."""

import math
from collections.abc import Mapping
from typing import Final

from surefetch.common.parameters import Parameters
from surefetch.evaluation.fitting.variants import FACTORIZED, NO_MEMORY, POOLED_VIEWS
from surefetch.evaluation.reporting import numbers
from surefetch.evaluation.reporting.comparisons import Comparison
from surefetch.evaluation.reporting.method_table import HEADS, family_cells, paper_cells
from surefetch.evaluation.reporting.paper_numbers import ABLATIONS as PAPER_ROWS
from surefetch.evaluation.reporting.plan import ABLATIONS, OURS, PAPER_METHOD, Key
from surefetch.evaluation.reporting.study_results import Study
from surefetch.evaluation.reporting.table import NA, Table

COLUMNS: Final = (
    "variant", "paper", "paper 95 %", "ours at the paper's size", *HEADS, "success",
    "95 % Wilson", "q̂", "difference, points", "95 %", "p (Holm)",
)  # fmt: skip
VARIANTS: Final = {"a1": POOLED_VIEWS, "a2": NO_MEMORY, "a3": FACTORIZED}


def tables(
    headline: Study,
    paper_size: Study,
    comparisons: Mapping[tuple[Key, Key], Comparison],
    parameters: Mapping[str, Parameters] | None,
    size: str,
) -> list[Table]:
    """One of the paper's method, one of ours.

    Args:
        headline: all results.
        paper_size: of the first scenes of each family.
        comparisons: by full method and ablation.
        parameters: that the results were made with, by profile; None: not at hand.
        size: what the size of `headline` may be called.
    """
    found = []
    for letter, full, name in (("a", PAPER_METHOD, "the paper's method"), ("b", OURS, "ours")):
        profile = full[1]
        keys = [("full", full), *((one, (one, profile)) for one in ABLATIONS)]
        rows = tuple(
            _row(code, key, headline, paper_size, comparisons.get((full, key)), parameters)
            for code, key in keys
        )
        notes = (
            "Difference: success of the ablation less that of the full method, on the same "
            "scenes. q̂ is estimated again for A1 to A3, on the calibration split.",
        )
        found.append(
            Table(f"Table III {letter}. Ablations of {name}, {size}", COLUMNS, rows, notes)
        )
    return found


def _row(
    code: str,
    key: Key,
    headline: Study,
    paper_size: Study,
    comparison: Comparison | None,
    parameters: Mapping[str, Parameters] | None,
) -> tuple[str, ...]:
    paper = paper_cells(PAPER_ROWS[code])[-2:]
    small, all_ = paper_size.played.get(key), headline.played.get(key)
    if small is None or all_ is None:
        return (PAPER_ROWS[code].name, *paper, *(NA,) * (len(COLUMNS) - 3))
    won = sum(e.verdict == "success" for e in small)
    k = sum(e.verdict == "success" for e in all_)
    found = None if comparison is None else comparison.difference
    interval = None if found is None else (-found.success[1], -found.success[0])
    return (
        PAPER_ROWS[code].name,
        *paper,
        f"{numbers.of(won, len(small))} {numbers.wilson_of(won, len(small))}",
        *family_cells(all_),
        numbers.share(k, len(all_)),
        numbers.wilson_of(k, len(all_)),
        _threshold(code, key, parameters),
        numbers.points(None if found is None else -found.gain),
        numbers.points_between(interval),
        numbers.p_value(None if comparison is None else comparison.p_holm),
    )


def _threshold(code: str, key: Key, parameters: Mapping[str, Parameters] | None) -> str:
    if parameters is None:
        return NA
    of = parameters[key[1]]
    variant = VARIANTS.get(code, "full")
    if variant not in of.calibrations:
        return NA
    q_hat = of.q_hat(variant)
    return "∞" if math.isinf(q_hat) else f"{q_hat:.4f}"
