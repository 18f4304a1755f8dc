"""The fitted observation model; how often actions succeed beside what the planner thinks. Pure."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from surefetch.common.hypotheses import CLASSES, OBSERVATIONS
from surefetch.common.parameters import Parameters
from surefetch.evaluation.reporting import numbers
from surefetch.evaluation.reporting.paper_numbers import FUTURE_CELLS
from surefetch.evaluation.reporting.scene_facts import Facts
from surefetch.evaluation.reporting.table import NA, Table

BELIEVED: Final = {"removal": "p_remove", "grasp": "p_grasp"}


def observation_models(parameters: Mapping[str, Parameters] | None) -> list[Table]:
    """E(y | q, c) of each profile, with its counts."""
    if parameters is None:
        return [Table("Observation model", ("viewing condition", *OBSERVATIONS), ())]
    return [_emission(profile, of) for profile, of in parameters.items()]


def execution(
    facts: Iterable[Facts] | None,
    trials: Sequence[Mapping[str, Any]] | None,
    parameters: Mapping[str, Parameters] | None,
) -> Table:
    """Success rates of actions.

    Args:
        facts: of the scenes; first attempts measured in the simulator count.
        trials: rows of `study episodes`, whose actions count.
        parameters: the planner's estimates.
    """
    measured = _measured(facts or ())
    closed_loop = _tried(trials or ())
    rows = []
    for action in sorted({*measured, *closed_loop, "removal", "grasp"}):
        tries = [of.get(action, (0, 0)) for of in (measured, closed_loop)]
        cells = [cell for k, n in tries for cell in (numbers.of(k, n), numbers.wilson_of(k, n))]
        rows.append((action, *cells, *_believed(action, parameters)))
    columns = (
        "action", "first attempts, measured", "95 %", "closed-loop trials", "95 %",
        "planner, paper", "planner, extended",
    )  # fmt: skip
    note = (
        "Measured: once a scene, at the target within reach; the paper's planner believes 4/5 and "
        "6/7, after 3/3 and 5/5 groups."
    )
    return Table("Execution", columns, tuple(rows), (note,))


def _emission(profile: str, of: Parameters) -> Table:
    model = of.emission()
    rows = tuple(
        (
            f"{q}, {c.replace('_', ' ')}",
            str(sum(of.emissions[q].get(c, ()))),
            *(numbers.number(float(p), 3) for p in model.likelihood(q)[row]),
        )
        for q in of.emissions
        for row, c in enumerate(CLASSES)
    )
    cells = sum(
        sum(row) > 0
        for by_y0 in of.paired.values()
        for table in by_y0.values()
        for row in table.values()
    )
    notes = [
        f"{cells} fitted cells of the planner's model of future observations (paper: "
        f"{FUTURE_CELLS}). Fitted on {of.fitted_on.n_episodes} {of.fitted_on.split} episodes, "
        f"seeds {of.fitted_on.seeds}."
    ]
    if of.attribute_evidence is not None:
        notes.append("This profile's belief uses evidence by attribute in the place of E.")
    columns = ("viewing condition, class", "n", *OBSERVATIONS)
    return Table(f"Observation model E(y | q, c), profile {profile}", columns, rows, tuple(notes))


def _measured(facts: Iterable[Facts]) -> dict[str, tuple[int, int]]:
    known = [one.measured for one in facts if one.measured is not None]
    removals = [m.removals[0].done for m in known if m.removals]
    grasps = [m.grasps[0].done for m in known if m.grasps]
    return {"removal": (sum(removals), len(removals)), "grasp": (sum(grasps), len(grasps))}


def _tried(trials: Sequence[Mapping[str, Any]]) -> dict[str, tuple[int, int]]:
    found: dict[str, tuple[int, int]] = {}
    for row in trials:
        for action in row.get("actions", ()):
            word = str(action["action"])
            kind = {"remove_cover": "removal", "grasp": "grasp"}.get(word.split(" ")[0], "view")
            k, n = found.get(kind, (0, 0))
            found[kind] = k + (action["status"] == "done"), n + 1
    return found


def _believed(action: str, parameters: Mapping[str, Parameters] | None) -> tuple[str, str]:
    if parameters is None or action not in BELIEVED:
        return NA, NA
    paper, extended = (
        numbers.number(getattr(parameters[p].priors, BELIEVED[action]), 3)
        for p in ("paper", "extended")
    )
    return paper, extended
