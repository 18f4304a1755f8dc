"""What the results say: tests, coverage, claims, and what they may be called. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from surefetch.evaluation.reporting import (
    calibration_tables,
    checks,
    claims,
    injected_table,
    plan,
    study_results,
)
from surefetch.evaluation.reporting.claims import Claim
from surefetch.evaluation.reporting.comparisons import Comparison, compare
from surefetch.evaluation.reporting.coverage import Coverage
from surefetch.evaluation.reporting.injected_table import Struck
from surefetch.evaluation.reporting.inputs import Inputs
from surefetch.evaluation.reporting.plan import Key
from surefetch.evaluation.reporting.study_results import Study


@dataclass(frozen=True, eq=False)
class Findings:
    """Everything computed once."""

    size: str
    not_headline: tuple[str, ...]
    """Why the results may not be called headline; empty: they may."""
    paper_size: Study
    groups: Mapping[str, list[Comparison]]
    struck: list[Struck]
    coverages: Mapping[Key, Coverage]
    claims: list[Claim]


def find(inputs: Inputs) -> Findings:
    """All tests and claims. Raises BadInput where too many episodes saw nothing."""
    study = inputs.study
    checks.refuse_exclusions(study)
    reasons = study_results.why_not_headline(study, inputs.openings)
    groups = {group.name: compare(study.played, group) for group in plan.GROUPS}
    struck = injected_table.struck(inputs.injected, [study, *inputs.others])
    coverages = calibration_tables.coverages(study, inputs.parameters)
    return Findings(
        size=_size(study, headline=not reasons),
        not_headline=tuple(reasons),
        paper_size=study.first(plan.PER_FAMILY["paper-size"]),
        groups=groups,
        struck=struck,
        coverages=coverages,
        claims=claims.claims(study, groups, coverages, struck),
    )


def summary(inputs: Inputs, found: Findings) -> dict[str, Any]:
    """Headline numbers, as programs read them."""
    return {
        "size": found.size,
        "headline": not found.not_headline,
        "why_not_headline": list(found.not_headline),
        "plan": plan.SHA256,
        "scenes": len(inputs.study.scenes),
        "policies": {
            "@".join(key): {
                "successes": sum(e.verdict == "success" for e in of),
                "episodes": len(of),
                "wrong_objects": sum(e.verdict == "wrong_object" for e in of),
                "mean_realized_cost": sum(e.realized_cost for e in of) / len(of),
            }
            for key, of in inputs.study.played.items()
        },
        "groups": {
            name: [
                {
                    "against": "@".join(one.second),
                    "p": one.p,
                    "p_holm": one.p_holm,
                    "holds": one.holds,
                }
                for one in group
            ]
            for name, group in found.groups.items()
        },
        "claims": [
            {"claim": one.what, "holds": one.holds, "found": one.found} for one in found.claims
        ],
    }


def _size(study: Study, *, headline: bool) -> str:
    if headline:
        return f"headline size, {len(study.scenes)} episodes"
    split = study.split or "mixed"
    return f"{len(study.scenes)} {split} episodes, not headline"
