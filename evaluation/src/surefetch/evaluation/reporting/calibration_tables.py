"""Tables of coverage, reliability, and risk against coverage. Pure."""

from collections.abc import Mapping, Sequence
from fractions import Fraction

from surefetch.common.parameters import Parameters
from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.reporting import commitment, coverage, names, numbers, reliability
from surefetch.evaluation.reporting.coverage import Coverage
from surefetch.evaluation.reporting.plan import OURS, PAPER_METHOD, Key
from surefetch.evaluation.reporting.study_results import Study
from surefetch.evaluation.reporting.table import NA, Table

COVERED = 0.8


def coverages(study: Study, parameters: Mapping[str, Parameters] | None) -> dict[Key, Coverage]:
    """Of both methods, at the level that they were calibrated for."""
    found = {}
    for key in (OURS, PAPER_METHOD):
        if key in study.played and parameters is not None:
            calibration = parameters[key[1]].calibration()
            one = coverage.observed(
                study.played[key], Fraction(calibration.alpha), calibration.provenance.n_episodes
            )
            if one is not None:
                found[key] = one
    return found


def coverage_table(study: Study, parameters: Mapping[str, Parameters] | None) -> Table:
    """Whether the conformal set held z* at every visited step, in all and by family."""
    rows = []
    for key, one in coverages(study, parameters).items():
        low, high = one.band
        band = f"{100 * low:.1f}–{100 * high:.1f} %"
        promised = numbers.percent(1 - float(one.alpha))
        sizes = coverage.set_sizes(study.played[key])
        told = ", ".join(f"{size}: {n}" for size, n in sizes.items())
        held = numbers.share(one.held, one.n), numbers.wilson_of(one.held, one.n)
        rows.append((names.of(key), "all", str(one.n), promised, *held, band, told))
        for family in FAMILIES:
            part = [e for e in study.played[key] if e.family == family and e.steps]
            k = sum(all(e.z_in_gamma) for e in part)
            cells = numbers.share(k, len(part)), numbers.wilson_of(k, len(part))
            sizes = coverage.set_sizes(part)
            told = ", ".join(f"{size}: {n}" for size, n in sizes.items()) or NA
            rows.append((names.of(key), family, str(len(part)), "not promised", *cells, NA, told))
    columns = (
        "method", "family", "episodes", "1 − α", "z* in Γ at every step", "95 % Wilson",
        "5–95 % of the true coverage", "|Γ| at the end: episodes",
    )  # fmt: skip
    note = (
        "Promised over all families together, for scenes like those of calibration; the range is "
        "that of Beta(k, n + 1 − k) for n calibration episodes."
    )
    return Table("Coverage of the conformal set", columns, tuple(rows), (note,))


def reliability_table(study: Study) -> Table:
    """Of the beliefs of both methods, in all and by viewing condition."""
    rows = []
    for key in (OURS, PAPER_METHOD):
        for condition, one in reliability.by_condition(study.played.get(key, ())).items():
            rows.append(
                (
                    names.of(key), condition, str(one.n), numbers.number(one.expected_error, 3),
                    numbers.number(one.brier, 3), numbers.number(one.log_score, 3),
                )
            )  # fmt: skip
    columns = ("belief of", "viewing condition", "looks", "expected error", "Brier", "log b(z*)")
    note = "Heaviest hypothesis in ten bins of equal count; Brier over all hypotheses, 0 to 2."
    return Table("Reliability of the belief", columns, tuple(rows), (note,))


def commitment_table(study: Study, keys: Sequence[Key]) -> Table:
    """Risk against coverage, in numbers."""
    rows = []
    for key in keys:
        if key not in study.played:
            continue
        points = commitment.curve(study.played[key])
        now = commitment.operating_point(study.played[key])
        rows.append(
            (
                names.of(key),
                numbers.number(commitment.area(points), 4),
                numbers.percent(commitment.risk_at(points, COVERED)),
                numbers.percent(None if now is None else now[0]),
                numbers.percent(None if now is None else now[1]),
            )
        )
    columns = (
        "method", "area under risk–coverage", f"risk at {COVERED:.0%} coverage",
        "coverage as played", "risk as played",
    )  # fmt: skip
    note = (
        "Area: mean risk over the coverages that are reached. Risk: share of grasps at another "
        "object. A curve that sweeps the planner's defer weight would need other runs: n/a."
    )
    return Table("Risk and coverage of grasping", columns, tuple(rows), (note,))
