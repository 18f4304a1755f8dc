"""Which of the planner's wishes the robot could carry out now, against the estimate alone.

Feasible means: planned to the end. For a grasp: a proposal whose hand pose has an inverse
kinematics inside the limits, a free approach, descent and lift, and a free path to it from the
present joints. For a view: a free path. For a cover: the whole removal, set-down included.
"""

import time

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.messages import (
    AskFeasible,
    Feasibility,
    GraspVerdict,
    InformVerdict,
)
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.skills.plans import Plans
from surefetch.executor.skills.situation import Situation


def judge(
    plans: Plans, cell: Cell, now: Situation, ask: AskFeasible, rng: np.random.Generator
) -> Feasibility:
    """One verdict for each track and each information action asked about, in order.

    Raises:
        BadInput: the cell file has no such information action.
    """
    began = time.perf_counter()
    grasps = tuple(judge_grasp(plans, now, track, rng) for track in ask.grasps)
    informs = tuple(judge_inform(plans, cell, now, name, rng) for name in ask.informs)
    return Feasibility(grasps=grasps, informs=informs, duration_s=time.perf_counter() - began)


def judge_grasp(plans: Plans, now: Situation, track: int, rng: np.random.Generator) -> GraspVerdict:
    """Whether a track can be grasped; what refused the proposals that came before, too."""
    pick, tried = plans.target(now, track, rng)
    refusal = tried.refusal
    if pick is not None:
        why = f"a grasp {1e3 * pick.way.object_width_m:.0f} mm wide"
        return GraspVerdict(track=track, feasible=True, refusal=None, why=why, tried=tried.counts)
    assert refusal is not None, "no plan and no refusal"
    return GraspVerdict(
        track=track, feasible=False, refusal=refusal.refusal, why=refusal.why, tried=tried.counts
    )


def judge_inform(
    plans: Plans, cell: Cell, now: Situation, name: str, rng: np.random.Generator
) -> InformVerdict:
    """Whether an information action can be carried out."""
    row = cell.inform(name)
    plan = plans.view(now, row.view, rng) if row.kind == "view" else plans.lid(now, rng)
    refused = plan if isinstance(plan, Infeasible) else None
    return InformVerdict(
        name=name,
        feasible=refused is None,
        refusal=refused.refusal if refused else None,
        why=refused.why if refused else "",
    )
