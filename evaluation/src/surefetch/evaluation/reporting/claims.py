"""What the results let one say: every sentence is made from numbers, and guarded by its test. Pure.

Source: EVALUATION, definition of "beats the paper"; docs/analysis-plan.md.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.reporting import names, numbers, pairs, plan
from surefetch.evaluation.reporting.comparisons import Comparison, Difference
from surefetch.evaluation.reporting.coverage import Coverage
from surefetch.evaluation.reporting.injected_table import Struck
from surefetch.evaluation.reporting.plan import OURS, PAPER_METHOD, Key
from surefetch.evaluation.reporting.study_results import Study
from surefetch.evaluation.reporting.table import NA, Table

PAPER_SHARE: Final = 0.6
"""Three of five: what the paper's method has in partial, covered and ambiguous."""
WORDS: Final = {True: "holds", False: "does not hold", None: "not known"}
NOT_REPRODUCED: Final = (
    "Not reproduced: the physical robot; Isaac Sim (PyBullet here); the paper's perception models, "
    "where their weights were not at hand (classical perception here); baselines that are driven "
    "by a language model, which are rules here."
)


@dataclass(frozen=True)
class Claim:
    """One claim, whether it holds, and the numbers that say so."""

    what: str
    holds: bool | None
    """None: not known."""
    found: str


def claims(
    study: Study,
    groups: Mapping[str, Sequence[Comparison]],
    coverages: Mapping[Key, Coverage],
    struck: Sequence[Struck],
) -> list[Claim]:
    """The definition of "beats the paper", and the figures that were aimed at."""
    primary = {one.second: one for one in groups["primary"]}
    against = primary[PAPER_METHOD].difference
    return [
        _all("higher success than the paper's method and every strong baseline", groups["primary"]),
        _no_family_worse(against),
        *(_above(study, family) for family in ("partial", "covered", "ambiguous")),
        _wrong(against),
        _all("against looking at everything and cheapest-first: success not worse, cost lower",
             groups["tertiary"]),
        _all("on the same belief, against every strong baseline: success not worse, cost lower",
             groups["same belief"]),
        _covered(coverages.get(OURS)),
        _injected("view@1", 0.8, struck),
        _grasp_failures(struck),
        *_aims(study, struck),
    ]  # fmt: skip


def table(found: Sequence[Claim]) -> Table:
    """As it is printed."""
    rows = tuple((one.what, WORDS[one.holds], one.found) for one in found)
    return Table("What holds", ("claim", "", "found"), rows, (NOT_REPRODUCED,))


def sentence(one: Comparison) -> str:
    """A comparison in words. "Higher" and "lower" only where the corrected p is below 0.05."""
    first, second = names.of(one.group.first), names.of(one.second)
    if one.difference is None:
        return f"{first} and {second} were not both played."
    found = one.difference
    p = f"p = {numbers.p_value(one.p_holm)} (Holm)".replace("= <", "<")
    gain = f"{numbers.points(found.gain)} points {numbers.points_between(found.success)}"
    if one.group.test == "not worse and cheaper":
        cost = f"realised cost {found.extra_cost:+.3f}"
        if one.holds:
            return f"{first} is not worse than {second} and its cost is lower: {gain}, {cost}, {p}."
        return f"Not shown that {first} is as good as {second} at lower cost: {gain}, {cost}, {p}."
    if one.holds:
        return f"The success of {first} is higher than that of {second}: {gain}, {p}."
    if found.gain < 0 and one.p_holm is not None and one.p_holm < plan.LEVEL:
        return f"The success of {first} is lower than that of {second}: {gain}, {p}."
    return f"The success of {first} and {second} is not told apart: {gain}, {p}."


def _all(what: str, found: Sequence[Comparison]) -> Claim:
    held = [one.holds for one in found]
    holds = False if False in held else None if None in held else True
    told = f"{held.count(True)} of {len(held)} hold, {held.count(None)} without data"
    return Claim(what, holds, told)


def _no_family_worse(found: Difference | None) -> Claim:
    what = "in no family more than 3 points below the paper's method"
    if found is None:
        return Claim(what, None, NA)
    each = pairs.by_family(found.pairs)
    worst = min(each, key=lambda family: each[family])
    told = f"worst: {worst}, {numbers.points(each[worst])} points"
    return Claim(what, each[worst] >= -plan.FAMILY_MARGIN, told)


def _above(study: Study, family: str) -> Claim:
    what = f"success in {family} above the paper's 3/5"
    part = [e for e in study.played.get(OURS, ()) if e.family == family]
    if not part:
        return Claim(what, None, NA)
    k = sum(e.verdict == "success" for e in part)
    return Claim(what, k / len(part) > PAPER_SHARE, _share(k, len(part)))


def _wrong(found: Difference | None) -> Claim:
    what = "wrong objects not more frequent than with the paper's method (bound below 2 points)"
    if found is None:
        return Claim(what, None, NA)
    told = (
        f"{numbers.points(float(found.pairs.extra_wrong.mean()))} points, "
        f"upper bound {numbers.points(found.wrong_bound)}"
    )
    return Claim(what, found.wrong_bound < plan.MARGIN, told)


def _covered(found: Coverage | None) -> Claim:
    what = "coverage of Γ over whole episodes as promised"
    if found is None:
        return Claim(what, None, NA)
    (low, high), (least, most) = found.interval, found.band
    told = (
        f"{_share(found.held, found.n)}; {numbers.percent(1 - float(found.alpha))} promised, true "
        f"coverage {100 * least:.1f}–{100 * most:.1f} %"
    )
    return Claim(what, high >= least and low <= most, told)


def _injected(kind: str, at_least: float, struck: Sequence[Struck]) -> Claim:
    what = f"success above {at_least:.0%} where {kind} is reported as failed (the paper: 0/5)"
    one = _of(kind, struck)
    if one is None or not one.with_it:
        return Claim(what, None, NA)
    n = len(one.with_it)
    return Claim(what, one.successes / n > at_least, _share(one.successes, n))


def _grasp_failures(struck: Sequence[Struck]) -> Claim:
    what = "success with injected grasp failures at least that without, less 5 points"
    one = _of("grasp@1", struck)
    if one is None or not one.without:
        return Claim(what, None, NA)
    n = len(one.with_it)
    before = sum(e.verdict == "success" for e in one.without)
    told = f"{numbers.of(one.successes, n)} with, {numbers.of(before, n)} without"
    return Claim(what, one.successes / n >= before / n - 0.05, told)


def _aims(study: Study, struck: Sequence[Struck]) -> list[Claim]:
    ours = study.played.get(OURS, ())
    rates = {
        family: [e.verdict == "success" for e in ours if e.family in (family, *_any(family))]
        for family in ("all", *FAMILIES)
    }
    wrong = [e.verdict == "wrong_object" for e in ours]
    found = []
    if ours:
        k, n = sum(rates["all"]), len(rates["all"])
        worst = min(FAMILIES, key=lambda f: sum(rates[f]) / max(1, len(rates[f])))
        found = [
            Claim("aim: success of at least 85 %", k / n >= 0.85, _share(k, n)),
            Claim(
                "aim: success of at least 75 % in every family",
                sum(rates[worst]) >= 0.75 * len(rates[worst]),
                f"lowest: {worst}, {_share(sum(rates[worst]), len(rates[worst]))}",
            ),
            Claim("aim: wrong objects at most 2 %", sum(wrong) <= 0.02 * n, _share(sum(wrong), n)),
        ]
    for kind, share in (("view@1", 0.95), ("grasp@1", 0.95), ("cover@1", 0.9)):
        one = _of(kind, struck)
        again, could = (0, 0) if one is None else one.recovered
        what = f"aim: {share:.0%} of episodes recover from {kind} that succeed without"
        found.append(Claim(what, again >= share * could if could else None, _share(again, could)))
    return found


def _any(family: str) -> tuple[str, ...]:
    return FAMILIES if family == "all" else ()


def _of(kind: str, struck: Sequence[Struck]) -> Struck | None:
    return next((one for one in struck if one.kind == kind and one.key == OURS), None)


def _share(k: int, n: int) -> str:
    return f"{k}/{n}, {numbers.share(k, n)} {numbers.wilson_of(k, n)}" if n else NA
