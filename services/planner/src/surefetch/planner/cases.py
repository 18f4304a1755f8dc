"""`surefetch solve CASES.json`: golden-format decision problems through the robot's own search."""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import msgspec

from surefetch.common.cases import (
    Case,
    Emissions,
    Paired,
    QHat,
    as_q_hat,
    print_answers,
    read_cases,
    solve_cases,
)
from surefetch.common.cell import simulated_cell
from surefetch.common.emission import Emission
from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.joint_belief import JointBelief
from surefetch.common.messages import QValue
from surefetch.common.parameters import PRINTED
from surefetch.planner import pomdpx, pomdpx_value
from surefetch.planner.actions import State
from surefetch.planner.futures import FutureModel
from surefetch.planner.problem import Options, Problem
from surefetch.planner.search import solve


class CaseTrack(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A track and its observation at the start of planning."""

    id: int
    y0: str | None


class PlanOptions(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Switches; a missing one is false."""

    pooled_views: bool = False
    factorized: bool = False
    hypothesis_independent_future: bool = False
    no_risk: bool = False
    no_conformal: bool = False
    no_defer: bool = False

    def of_search(self) -> Options:
        """Those that concern the search; `pooled_views` concerns the emission."""
        return Options(
            factorized=self.factorized,
            hypothesis_independent_future=self.hypothesis_independent_future,
            no_risk=self.no_risk,
            no_conformal=self.no_conformal,
            no_defer=self.no_defer,
        )


class PlanCase(Case, frozen=True):
    """A decision to take, with the paper's costs and the default information actions."""

    emissions: Emissions
    paired: Paired
    belief: dict[str, float]
    tracks: tuple[CaseTrack, ...]
    state: State
    used: tuple[str, ...]
    feasible: tuple[int, ...]
    instruction: AskedRelation
    q_hat: QHat
    horizon: int
    options: PlanOptions = PlanOptions()

    def solve(self) -> dict[str, Any]:
        """The conformal set, every Q value, V and the chosen action."""
        solution = solve(self.problem())
        return {
            "gamma": list(solution.gamma),
            "Q": [{**_action(q), "value": q.value} for q in solution.q_values],
            "V": solution.value,
            "chosen": None if solution.chosen is None else _action(solution.chosen),
            "nodes": solution.nodes,
        }

    def problem(self) -> Problem:
        """The case as the search takes it."""
        belief = JointBelief.read(self.belief)
        y0 = {track.id: track.y0 for track in self.tracks}
        return Problem(
            belief=belief,
            y0=tuple(y0[i] for i in belief.tracks),
            state=self.state,
            used=frozenset(self.used),
            feasible=frozenset(self.feasible),
            asked=self.instruction,
            q_hat=as_q_hat(self.q_hat),
            horizon=self.horizon,
            rows=simulated_cell().informs,
            future=FutureModel(
                Emission(self.emissions, pooled_views=self.options.pooled_views), self.paired
            ),
            p_remove=PRINTED.p_remove,
            p_grasp=PRINTED.p_grasp,
            options=self.options.of_search(),
        )


KINDS: Final[dict[str, type[Case]]] = {"plan": PlanCase}
FORMATS: Final = ("pomdpx",)
"""Of exported problems."""

HELP: Final = """\
example of CASES.json, with one case:
  [{"kind": "plan", "name": "look", "emissions": {}, "paired": {},
    "belief": {"1:inside": 0.75, "1:outside": 0.0625, "unobs": 0.0625, "abs": 0.125},
    "tracks": [{"id": 1, "y0": null}], "state": "open", "used": [], "feasible": [1],
    "instruction": "any", "q_hat": 0.6, "horizon": 1}]

Every field is described in tests/golden/cases/README.md. Prints a JSON list with one object for
each case.

example of an export: surefetch solve cases.json --case look --export pomdpx look.pomdpx

A POMDP has no rules that hang on the belief. The exported one lets every grasp through that
instruction and cover allow (as no_conformal does, for all tracks and relations), and lets one
abstain at any time. The printed V is its least expected cost, exactly, which is at most the V that
surefetch solves to; a solver that reads the file should come to -V.
"""


def main(argv: list[str]) -> int:
    """Solve every case of a file, or export one. Raises BadInput that names case and field."""
    asked = _parser().parse_args(argv)
    cases = read_cases(asked.cases, KINDS, command="surefetch solve")
    if asked.case is not None:
        cases = [_named(cases, asked.case, asked.cases)]
    if asked.export is None:
        print_answers(solve_cases(cases))
    else:
        print_answers([_exported(_only(cases), *asked.export)])
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch solve",
        description="Decision problems in, Q values and the chosen action out; or one of them as a "
        "file for other POMDP solvers.",
        epilog=HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("cases", type=Path, metavar="CASES.json")
    parser.add_argument("--case", metavar="NAME", help="only the case of this name")
    parser.add_argument(
        "--export",
        nargs=2,
        metavar=("FORMAT", "FILE"),
        help=f"write the problem of one case for other solvers; formats: {', '.join(FORMATS)}",
    )
    return parser


def _named(cases: Sequence[Case], name: str, path: Path) -> Case:
    for case in cases:
        if case.name == name:
            return case
    known = ", ".join(case.name for case in cases)
    raise BadInput(f'case file {path} has no case "{name}".\n  Cases: {known}')


def _only(cases: Sequence[Case]) -> PlanCase:
    match cases:
        case [PlanCase() as one]:
            return one
        case _:
            raise BadInput(
                f"--export writes one case, and {len(cases)} were given. Choose one: --case NAME"
            )


def _exported(case: PlanCase, form: str, file: str) -> dict[str, Any]:
    """Write one case; its name, the file and the least expected cost of what is in it."""
    if form not in FORMATS:
        raise BadInput(f'--export: there is no format "{form}". Formats: {", ".join(FORMATS)}')
    try:
        problem = case.problem()
        written = pomdpx.document(problem, case.name)
    except (ValueError, KeyError) as error:
        raise BadInput(f"case {case.name}: {error}") from None
    try:
        Path(file).write_bytes(written)
    except OSError as error:
        raise BadInput(f"--export: {file} cannot be written: {error.strerror}") from None
    return {"name": case.name, "file": file, "V": pomdpx_value.value(problem)}


def _action(q: QValue) -> dict[str, Any]:
    if q.track is None:
        return {"action": q.action}
    return {"action": q.action, "track": q.track, "relation": q.relation}
