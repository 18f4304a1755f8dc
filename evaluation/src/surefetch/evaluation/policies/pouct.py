"""POUCT: Monte-Carlo tree search over the hypotheses, rebuilt at every step.

Lite foresees what the paper's planner does, one track drawn from all for every look, and rolls out
by chance. Strong foresees the categories of all tracks at once and that a target may appear that
has no track yet, and rolls out to the best end that the history justifies. The gated variants let
through at the root what the planner's rules admit; in the tree nothing is gated.

Source: Silver and Veness, Monte-Carlo Planning in Large POMDPs (2010); Zheng and Tellex, pomdp_py
(2020), which plans.
"""

from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Any, Final

from surefetch.common.errors import BadInput
from surefetch.common.messages import Choice
from surefetch.evaluation.policies.decision import foreseen, gated, problem_of, ungated
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.tuning import Scalar

SCALARS: Final = (
    Scalar("exploration", (0.3, 1.0, 3.0)),
    Scalar("simulations", (1000.0, 5000.0, 20000.0)),
)
SIMULATIONS: Final = 20_000
"""Of a plan where none was tuned: views whose costs differ by 0.001 are not told apart by fewer."""


@dataclass
class Pouct:
    """Plans anew at every step."""

    strong: bool
    gate: bool
    exploration: float = 1.0
    """Returns range over about one."""
    simulations: float = SIMULATIONS
    """A whole number."""
    because: str = field(default="", init=False, repr=False, compare=False)

    def act(self, now: Observation) -> Choice | None:
        """The action of the lowest mean cost over the simulations; None: none is admissible.

        Raises:
            BadInput: pomdp_py is not installed.
        """
        tree = _tree()
        at_root = gated(now) if self.gate else ungated(now)
        if not at_root:
            return None
        problem = foreseen(now) if self.strong else replace(problem_of(now), p_appears={})
        choice, cost = tree.plan(
            problem,
            at_root,
            strong=self.strong,
            exploration=self.exploration,
            simulations=int(self.simulations),
            rng=now.rng,
        )
        self.because = f"{int(self.simulations)} simulations cost {cost:.3f} on average."
        found: Choice = choice
        return found


def _tree() -> Any:
    try:
        return import_module("surefetch.evaluation.policies.pouct_tree")
    except ModuleNotFoundError as error:
        if error.name != "pomdp_py":
            raise
        raise BadInput(
            "POUCT needs pomdp_py, which is not installed here.\n"
            '  Install it: pip install "surefetch-evaluation[baselines]"'
        ) from None
