"""Episodes that nobody played, for the report."""

from collections.abc import Sequence

import msgspec

from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.replaying.manifest import Manifest
from surefetch.evaluation.replaying.results import EpisodeResult, GraspResult, StepResult
from surefetch.evaluation.running.metrics import VERDICTS, Scored, Verdict, realized_cost

STEP = StepResult(
    view="center", cover="none", q="center", counted=True, delivered="0",
    observations=("1 MI", "2 mismatch"), belief={"1:inside": 0.8, "2:inside": 0.1}, unobs=0.05,
    abs=0.05, gamma=("1:inside",), z_true="1:inside", p_true=0.8, action="grasp 1 inside",
    because="", planning_s=0.01,
)  # fmt: skip
GRASP = GraspResult(
    track=1, relation="inside", p=0.8, body="target", on_target=True, held=True, injected=False
)


def episode(
    verdict: Verdict = "success",
    *,
    family: str = "partial",
    seed: int = 100_000,
    policy: str = "ours",
    profile: str = "extended",
    steps: Sequence[StepResult] = (STEP,),
    commit_p: float = 0.8,
    cost: float = 0.012,
) -> EpisodeResult:
    """One; it grasped where its verdict needs that."""
    grasped = {
        "success": (GRASP,),
        "grasp_failed": (msgspec.structs.replace(GRASP, held=False),),
        "wrong_object": (msgspec.structs.replace(GRASP, on_target=False, body="other"),),
    }.get(verdict, ())
    present = family != "absent"
    if not present and verdict == "success":
        grasped = ()
    return EpisodeResult(
        policy=policy,
        profile=profile,
        variant="full",
        family=family,
        seed=seed,
        stratum="",
        covered=family == "covered",
        asked="inside",
        target_present=present,
        verdict=verdict,
        outcome="grasped" if grasped else "deferred",
        reason="",
        why="",
        actions=("right", "grasp 1 inside" if grasped else "defer"),
        n_actions=2,
        cost=cost,
        realized_cost=realized_cost(Scored(family, seed, verdict, 2, cost)),
        duration_s=12.0,
        commit_p=commit_p,
        grasps=grasped,
        q_hat=0.5,
        steps=tuple(steps),
    )


def so_many(**counts: int) -> list[Verdict]:
    """Verdicts by name, each so many times."""
    return [verdict for verdict in VERDICTS for _ in range(counts.get(verdict, 0))]


def episodes(
    verdicts: Sequence[Verdict],
    policy: str = "ours",
    profile: str = "extended",
    first_seed: int = 100_000,
) -> list[EpisodeResult]:
    """One for each verdict, the families in turn."""
    return [
        episode(
            verdict,
            family=FAMILIES[n % len(FAMILIES)],
            seed=first_seed + n // len(FAMILIES),
            policy=policy,
            profile=profile,
        )
        for n, verdict in enumerate(verdicts)
    ]


def manifest(**made_with: object) -> Manifest:
    """Of results made with this."""
    return Manifest({"parameters": {"paper": "p", "extended": "e"}} | made_with, {})
