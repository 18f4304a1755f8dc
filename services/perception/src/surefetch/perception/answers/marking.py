"""Which marking a body carries. Pure."""

from typing import Final

from surefetch.common.messages import Answer
from surefetch.perception.answers.answer import identity
from surefetch.perception.answers.look import Look, best_solid
from surefetch.perception.answers.patches import carriers_known
from surefetch.perception.answers.patterns import PLAIN

MARKINGS: Final = (PLAIN, "stripe", "dot", "cross")
LEAST_PX: Final = 10.0
COST_SHARE: Final = 0.35
"""Of the pixels that even the best explanation leaves unexplained."""


def marking(look: Look, asked: str, *, pose_known: bool) -> Answer:
    """Whether the body carries the asked marking.

    The margin is by how many pixels the asked kind explains the picture better than all others.
    """
    found = look.explanations
    if not found:
        return identity(0.0, 1.0, {"n_px": look.candidate.n_px})
    costs = {kind: found[kind].cost_px if kind in found else look.n_marked_px for kind in MARKINGS}
    solid = best_solid(look.candidate)
    if solid is None or not (pose_known and carriers_known(solid)):
        # any face may carry a marking, also one turned away
        costs = {kind: min(cost, costs[PLAIN]) for kind, cost in costs.items()}
    rivals = {kind: cost for kind, cost in costs.items() if kind != asked}
    best = min(costs.values())
    margin = min(rivals.values()) - costs[asked]
    unit = LEAST_PX + COST_SHARE * best
    evidence = {f"cost_{kind}_px": cost for kind, cost in costs.items()}
    return identity(margin / unit, 1.0, evidence | {"marked_px": look.n_marked_px, "unit_px": unit})
