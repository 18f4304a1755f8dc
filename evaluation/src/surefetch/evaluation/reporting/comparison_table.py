"""The pre-declared comparisons in full, and where two policies differ. Pure."""

from collections.abc import Sequence
from typing import Final

from surefetch.evaluation.reporting import names, numbers, pairs
from surefetch.evaluation.reporting.comparisons import Comparison
from surefetch.evaluation.reporting.plan import MARGIN, Group
from surefetch.evaluation.reporting.table import NA, Table

COLUMNS: Final = (
    "against", "only first", "only second", "ψ", "success, points", "95 %", "p", "p (Holm)",
    "lower bound, points", "realised cost", "95 %", "p cost", "odds ratio (MH)",
    "families + / − / =", "leaving one family out", "holds",
)  # fmt: skip


def table(group: Group, found: Sequence[Comparison]) -> Table:
    """One group."""
    if group.test == "success":
        what = "p: exact McNemar, two-sided. Holds: success is higher, and p (Holm) < 0.05."
    else:
        what = (
            f"p: the larger of the p of being worse by {100 * MARGIN:.0f} points (resampling) and "
            "of equal realised cost (sign flips). Holds: cost is lower, and p (Holm) < 0.05."
        )
    missing = sum(one.difference is None for one in found)
    notes = [what, "Differences: the first less the other, on the same scenes."]
    if missing:
        notes.append(
            f"{missing} of the group's {len(found)} tests have no data; p is corrected for "
            f"{len(found)} all the same."
        )
    return Table(
        f"Group {group.name}: {names.of(group.first)} against {len(found)}",
        COLUMNS,
        tuple(map(_row, found)),
        tuple(notes),
    )


def _row(one: Comparison) -> tuple[str, ...]:
    if one.difference is None:
        return (names.of(one.second), *(NA,) * (len(COLUMNS) - 1))
    found = one.difference
    both = found.pairs
    each = list(pairs.by_family(both).values())
    left_out = pairs.without_each_family(both).values()
    signs = (sum(d > 0 for d in each), sum(d < 0 for d in each), sum(d == 0 for d in each))
    return (
        names.of(one.second),
        str(both.only_first),
        str(both.only_second),
        numbers.number(both.psi, 3),
        numbers.points(found.gain),
        numbers.points_between(found.success),
        numbers.p_value(one.p),
        numbers.p_value(one.p_holm),
        numbers.points(found.success_bound),
        f"{found.extra_cost:+.3f}",
        f"[{found.cost[0]:+.3f}, {found.cost[1]:+.3f}]",
        numbers.p_value(found.p_cost),
        numbers.number(pairs.odds_ratio(both), 2),
        " / ".join(map(str, signs)),
        f"{numbers.points(min(left_out))} to {numbers.points(max(left_out))}" if left_out else NA,
        {True: "yes", False: "no", None: NA}[one.holds],
    )
