"""`surefetch solve CASES.json`: golden-format decision problems through the robot's own search."""

import argparse
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
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.joint_belief import JointBelief
from surefetch.common.messages import QValue
from surefetch.common.parameters import PRINTED
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

HELP: Final = """\
example of CASES.json, with one case:
  [{"kind": "plan", "name": "look", "emissions": {}, "paired": {},
    "belief": {"1:inside": 0.75, "1:outside": 0.0625, "unobs": 0.0625, "abs": 0.125},
    "tracks": [{"id": 1, "y0": null}], "state": "open", "used": [], "feasible": [1],
    "instruction": "any", "q_hat": 0.6, "horizon": 1}]

Every field is described in tests/golden/cases/README.md. Prints a JSON list with one object for
each case.
"""


def main(argv: list[str]) -> int:
    """Solve every case of a file. Raises BadInput that names the case and the field."""
    parser = argparse.ArgumentParser(
        prog="surefetch solve",
        description="Decision problems in, Q values and the chosen action out.",
        epilog=HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("cases", type=Path, metavar="CASES.json")
    path = parser.parse_args(argv).cases
    print_answers(solve_cases(read_cases(path, KINDS, command="surefetch solve")))
    return 0


def _action(q: QValue) -> dict[str, Any]:
    if q.track is None:
        return {"action": q.action}
    return {"action": q.action, "track": q.track, "relation": q.relation}
