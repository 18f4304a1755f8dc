"""Numbers as the report prints them; what is not known is `n/a`. Pure."""

import math
import statistics
from collections.abc import Callable, Iterable, Sequence

from surefetch.evaluation.reporting.table import NA
from surefetch.evaluation.running.metrics import wilson


def share(k: int, n: int) -> str:
    """`k` of `n`, in per cent."""
    return percent(k / n) if n else NA


def percent(value: float | None) -> str:
    """A share, with one decimal."""
    return NA if value is None else f"{100 * value:.1f} %"


def points(value: float | None) -> str:
    """A difference of shares, in percentage points, with its sign."""
    return NA if value is None else f"{100 * value:+.1f}"


def points_between(interval: tuple[float, float] | None) -> str:
    """An interval of differences of shares."""
    if interval is None:
        return NA
    return f"[{100 * interval[0]:+.1f}, {100 * interval[1]:+.1f}]"


def of(k: int, n: int) -> str:
    """`k/n`."""
    return f"{k}/{n}" if n else NA


def wilson_of(k: int, n: int) -> str:
    """The 95 % Wilson interval of `k` in `n`, in per cent."""
    if not n:
        return NA
    low, high = wilson(k, n)
    return f"[{100 * low:.1f}, {100 * high:.1f}]"


def p_value(p: float | None) -> str:
    """A p value; small ones as a bound."""
    if p is None:
        return NA
    return "< 0.0001" if p < 1e-4 else f"{p:.4f}"


def number(value: float | None, digits: int) -> str:
    """With so many decimals."""
    if value is None:
        return NA
    return "∞" if math.isinf(value) else f"{value:.{digits}f}"


def mean(values: Iterable[float], digits: int) -> str:
    """Of some values, with so many decimals."""
    listed = list(values)
    return number(statistics.fmean(listed), digits) if listed else NA


def milliseconds(values: Sequence[float], at: Callable[[Sequence[float]], float]) -> str:
    """A statistic of times in seconds, printed in milliseconds."""
    return f"{1e3 * at(values):.1f}" if values else NA


def p95(values: Sequence[float]) -> float:
    """The 95th percentile of at least one value: the smallest that 95 % do not pass."""
    return sorted(values)[max(0, math.ceil(0.95 * len(values)) - 1)]
