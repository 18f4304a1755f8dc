"""Results to the whole report: sentences, tables and figures in order. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.reporting import (
    ablation_table,
    calibration_tables,
    cause_table,
    checks,
    claims,
    commitment,
    comparison_table,
    coverage,
    ending_table,
    figures,
    generator_table,
    injected_table,
    method_table,
    model_table,
    names,
    pairs,
    perception_table,
    plan,
    reliability,
    study_results,
)
from surefetch.evaluation.reporting.claims import Claim
from surefetch.evaluation.reporting.comparisons import Comparison, compare
from surefetch.evaluation.reporting.coverage import Coverage
from surefetch.evaluation.reporting.injected_table import Struck
from surefetch.evaluation.reporting.inputs import Inputs
from surefetch.evaluation.reporting.page import Page, Part, Picture
from surefetch.evaluation.reporting.plan import ABLATIONS, OURS, PAPER_METHOD, STRONG, Key
from surefetch.evaluation.reporting.study_results import Study
from surefetch.evaluation.reporting.table import Table
from surefetch.evaluation.running.metrics import failure_classes

DRAWN: Final[tuple[Key, ...]] = (
    OURS, PAPER_METHOD, ("exhaustive-look", "extended"), *((name, "paper") for name in STRONG),
)  # fmt: skip
"""Whose curves of risk and coverage are drawn."""


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


def page(
    inputs: Inputs, found: Findings, traces: Sequence[Picture], made_by: tuple[str, str]
) -> Page:
    """The report.

    Args:
        inputs: what it is made from.
        found: what `find` found in it.
        traces: pictures of single episodes.
        made_by: the command that reports, and the commit of its sources, which may be empty.
    """
    parts = [
        Part("What holds", _sentences(found), (claims.table(found.claims),)),
        Part("Table I: scenarios", tables=_scenarios(inputs)),
        Part("Table II: methods", tables=_methods(inputs, found)),
        Part("Comparisons as declared", _too_small(inputs, found), _comparisons(found)),
        Part("Table III: ablations", tables=_ablations(inputs, found)),
        Part("Table IV and injected failures", tables=_injected(inputs, found)),
        Part("Coverage, reliability, risk", (), *_calibration(inputs)),
        Part("Where it fails", (), *_failures(inputs)),
        Part("Traces", (_TRACES,), (), tuple(traces)),
        Part("Perception, observation model, execution", tables=_models(inputs)),
        Part("Other draws of the outcomes", tables=_draws(inputs)),
        Part("Endings by family", (), (ending_table.endings_by_family(inputs.study),), (), True),
        Part("Checks, ledger and commands", tables=_provenance(inputs)),
    ]
    return Page(
        title=f"surefetch: the paper's experiment, {found.size}",
        lead=_lead(inputs, *made_by),
        warnings=_warnings(found),
        parts=tuple(part for part in parts if part.sentences or part.tables or part.pictures),
    )


NOWHERE: Final = "an installed package"
"""Where there is no commit to name."""
_TRACES: Final = (
    "By rule: the first episode of the ambiguous family, by seed, in which ours took at least two "
    "views and succeeded; and the first failure of each family, where there is one."
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


def _lead(inputs: Inputs, command: str, commit: str) -> tuple[str, ...]:
    made = inputs.study.manifest.made_with
    seeds = [seed for _, seed in inputs.study.scenes]
    return (
        f"{len(inputs.study.played)} policies on {len(inputs.study.scenes)} recorded scenes, "
        f"{inputs.study.per_family} or more of each family, seeds {min(seeds)} to {max(seeds)}; "
        f"outcomes of actions: {made.get('outcomes')}. Every policy had the same scenes, images, "
        "tracks, feasibility and outcomes.",
        "Numbers of the paper stand in columns of their own. Its scenes, simulator, perception and "
        "execution are not ours; nothing is pooled, and no test is made across them.",
        f"Analysis plan: docs/analysis-plan.md, SHA-256 {plan.SHA256}. Reported by "
        f"{commit or NOWHERE}: `{command}`.",
    )


def _warnings(found: Findings) -> tuple[str, ...]:
    if not found.not_headline:
        return ()
    return ("These are not headline results: " + "; ".join(found.not_headline) + ".",)


def _sentences(found: Findings) -> tuple[str, ...]:
    wanted = ("primary", "same belief", "tertiary")
    return tuple(
        claims.sentence(one)
        for name in wanted
        for one in found.groups[name]
        if one.difference is not None
    )


def _scenarios(inputs: Inputs) -> tuple[Table, ...]:
    table = generator_table.table(inputs.study, inputs.facts)
    return (table,) if inputs.facts is None else (table, generator_table.rejections(inputs.facts))


def _methods(inputs: Inputs, found: Findings) -> tuple[Table, ...]:
    tests = {one.second: one for one in found.groups["primary"] if one.difference is not None}
    return tuple(method_table.blocks(inputs.study, found.paper_size, tests, found.size))


def _too_small(inputs: Inputs, found: Findings) -> tuple[str, ...]:
    """On development: whether the plan asks for more scenes than headline has."""
    close = [
        one.difference.pairs.psi
        for one in found.groups["primary"]
        if one.difference is not None and abs(one.difference.gain) <= plan.CLOSE
    ]
    if inputs.study.split != "development":
        return ()
    if not close:
        return ("No primary pair is within 5 points on development, so 600 scenes do.",)
    more = "so 1,000 scenes are taken" if max(close) > plan.LARGEST_PSI else "so 600 scenes do"
    return (f"ψ of close primary pairs is at most {max(close):.3f} on development, {more}.",)


def _comparisons(found: Findings) -> tuple[Table, ...]:
    return tuple(comparison_table.table(group, found.groups[group.name]) for group in plan.GROUPS)


def _ablations(inputs: Inputs, found: Findings) -> tuple[Table, ...]:
    tests = {
        (one.group.first, one.second): one
        for name in ("secondary", "secondary, paper's method")
        for one in found.groups[name]
    }
    return tuple(
        ablation_table.tables(inputs.study, found.paper_size, tests, inputs.parameters, found.size)
    )


def _injected(inputs: Inputs, found: Findings) -> tuple[Table, ...]:
    return (
        injected_table.physical(inputs.study, found.struck),
        injected_table.table(found.struck),
    )


def _calibration(inputs: Inputs) -> tuple[tuple[Table, ...], tuple[Picture, ...]]:
    study = inputs.study
    drawn = [key for key in DRAWN if key in study.played]
    tables = (
        calibration_tables.coverage_table(study, inputs.parameters),
        calibration_tables.reliability_table(study),
        calibration_tables.commitment_table(study, drawn),
    )
    curves = {
        names.short(k): (
            commitment.curve(study.played[k]), commitment.operating_point(study.played[k])
        )
        for k in drawn
    }  # fmt: skip
    levels = _levels(inputs)
    reliable = {
        names.short(k): reliability.of(steps)
        for k in (OURS, PAPER_METHOD)
        if (steps := [s for e in study.played.get(k, ()) for s in e.steps if s.counted])
    }
    pictures = [
        Picture("risk-coverage.svg", "Risk against coverage; dots: as played.",
                figures.risk_coverage(curves)),
        Picture("coverage.svg", "Coverage of Γ over whole episodes against 1 − α, Wilson bars; "
                "band: 5–95 % of the true coverage over draws of the calibration scenes.",
                figures.coverage(levels)),
        Picture("reliability.svg", "Reliability of the belief: ten bins of equal count.",
                figures.reliability(reliable)),
    ]  # fmt: skip
    return tables, tuple(pictures)


def _levels(inputs: Inputs) -> dict[str, list[Coverage]]:
    """Coverage at all levels where calibration scores are at hand, else at the one that ships."""
    single = calibration_tables.coverages(inputs.study, inputs.parameters)
    found: dict[str, list[Coverage]] = {}
    for key in (OURS, PAPER_METHOD):
        if key not in inputs.study.played:
            continue
        scores = inputs.scores.get(key[1])
        if scores is not None:
            found[names.short(key)] = coverage.at_all_levels(inputs.study.played[key], scores)
        elif key in single:
            found[names.short(key)] = [single[key]]
    return found


def _failures(inputs: Inputs) -> tuple[tuple[Table, ...], tuple[Picture, ...]]:
    study = inputs.study
    mains = [key for key in (OURS, PAPER_METHOD) if key in study.played]
    tables: list[Table] = [ending_table.endings(study)]
    counts = {
        names.short(k): failure_classes([e.scored for e in of]) for k, of in study.played.items()
    }
    spent = {
        names.short(key): (
            sum(e.cost for e in of) / len(of), sum(e.verdict == "success" for e in of), len(of)
        )
        for key, of in study.played.items()
    }  # fmt: skip
    order = [key for key in study.played if key[0] not in ABLATIONS]
    pictures = [
        Picture("classes.svg", "How episodes ended.", figures.classes(counts)),
        Picture("cost-success.svg", "Success against mean action cost.",
                figures.cost_success(spent)),
        Picture("psi.svg", "ψ, in per cent: scenes on which one of two methods succeeds.",
                figures.discordances([names.short(k) for k in order], _psi(study, order))),
    ]  # fmt: skip
    if inputs.facts is not None and mains:
        facts = inputs.facts
        tables += [cause_table.cause_table(study, facts, key) for key in mains]
        tables.append(cause_table.strata_table(study, facts, mains))
        strata = {names.short(key): cause_table.by_occlusion(study, facts, key) for key in mains}
        caption = "Success by occlusion of the target in the first look."
        pictures.append(Picture("occlusion.svg", caption, figures.strata(strata)))
    return tuple(tables), tuple(pictures)


def _psi(study: Study, keys: Sequence[Key]) -> pairs.Floats:
    won = np.array([[e.verdict == "success" for e in study.played[key]] for key in keys])
    return np.asarray(np.mean(won[:, None, :] != won[None, :, :], axis=2), np.float64)


def _models(inputs: Inputs) -> tuple[Table, ...]:
    facts = None if inputs.facts is None else inputs.facts.values()
    return (
        perception_table.table(inputs.perception),
        model_table.execution(facts, inputs.trials, inputs.parameters),
        *model_table.observation_models(inputs.parameters),
    )


def _draws(inputs: Inputs) -> tuple[Table, ...]:
    """Success under each folder's outcomes."""
    folders = [one for one in inputs.others if one.scenes == inputs.study.scenes]
    if not folders:
        return ()
    rows = []
    for one in (inputs.study, *folders):
        for key, of in one.played.items():
            cells = method_table.cells(of)
            outcomes = str(one.manifest.made_with.get("outcomes"))
            rows.append((names.of(key), outcomes, *cells[: len(FAMILIES) + 3]))
    columns = ("method", "outcomes", *method_table.COLUMNS[1 : len(FAMILIES) + 4])
    return (Table("Success under other outcomes of the same actions", columns, tuple(rows)),)


def _provenance(inputs: Inputs) -> tuple[Table, ...]:
    audit = () if inputs.audit is None else (checks.audit_table(inputs.audit),)
    return (
        checks.table(inputs.study),
        *audit,
        checks.ledger_table(inputs.openings),
        checks.commands_table(inputs.study),
    )
