"""Results to the whole report: sentences, tables and figures in order. Pure."""

from collections.abc import Sequence
from typing import Final

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.reporting import (
    ablation_table,
    checks,
    claims,
    comparison_table,
    ending_table,
    generator_table,
    illustrated,
    injected_table,
    method_table,
    model_table,
    names,
    perception_table,
    plan,
)
from surefetch.evaluation.reporting.findings import Findings
from surefetch.evaluation.reporting.inputs import Inputs
from surefetch.evaluation.reporting.page import Page, Part, Picture
from surefetch.evaluation.reporting.table import Table


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
        Part("Coverage, reliability, risk", (), *illustrated.calibration(inputs)),
        Part("Where it fails", (), *illustrated.failures(inputs)),
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
