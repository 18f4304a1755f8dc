"""The parts of the report that have figures. Pure."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from surefetch.evaluation.reporting import (
    calibration_tables,
    cause_table,
    commitment,
    coverage,
    ending_table,
    figures,
    names,
    pairs,
    reliability,
)
from surefetch.evaluation.reporting.coverage import Coverage
from surefetch.evaluation.reporting.inputs import Inputs
from surefetch.evaluation.reporting.page import Picture
from surefetch.evaluation.reporting.plan import ABLATIONS, OURS, PAPER_METHOD, STRONG, Key
from surefetch.evaluation.reporting.study_results import Study
from surefetch.evaluation.reporting.table import Table
from surefetch.evaluation.running.metrics import failure_classes

DRAWN: Final[tuple[Key, ...]] = (
    OURS, PAPER_METHOD, ("exhaustive-look", "extended"), *((name, "paper") for name in STRONG),
)  # fmt: skip
"""Whose curves of risk and coverage are drawn."""


def calibration(inputs: Inputs) -> tuple[tuple[Table, ...], tuple[Picture, ...]]:
    """Coverage, reliability, and risk against coverage."""
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


def failures(inputs: Inputs) -> tuple[tuple[Table, ...], tuple[Picture, ...]]:
    """How episodes ended, what it cost, and where failures come from."""
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
