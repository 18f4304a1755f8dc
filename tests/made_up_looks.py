"""Looks of a walk, by hand: what counted for which track, and what was true."""

import numpy as np

from surefetch.common.hypotheses import ABS, UNOBS, tracked
from surefetch.common.messages import Answers, Assigned, BeliefReply, Track
from surefetch.evaluation.recordings.walk import Look


def look(
    q: str,
    observations: dict[int, str],
    *,
    y0: dict[int, str] | None = None,
    new: tuple[int, ...] = (),
    target_track: int | None = None,
    relation: str | None = "inside",
    p_truth: float = 0.5,
    belief: dict[str, float] | None = None,
    answers: dict[str, Answers] | None = None,
) -> Look:
    """One look. `y0` are the tracks after it with their latest observation."""
    if relation is None:
        truth = ABS
    else:
        truth = UNOBS if target_track is None else tracked(target_track, relation)
    latest = observations if y0 is None else y0
    reply = BeliefReply(
        episode="made-up",
        step=0,
        tracks=tuple(track(i, y) for i, y in latest.items()),
        assigned=tuple(
            Assigned(detection=f"{q}-{i}", track=i, y=y, counted=True)
            for i, y in observations.items()
        ),
        prior={},
        belief={truth: p_truth} if belief is None else belief,
        gamma=(),
        q_hat=0.9,
        digest="0",
    )
    bodies: dict[int, str | None] = {i: "target" if i == target_track else "other" for i in latest}
    return Look(q, reply, new, target_track, truth, bodies, answers or {})


def track(number: int, y0: str) -> Track:
    """A track of which only the latest observation matters."""
    return Track(
        id=number,
        center_world_m=(0.9, 0.0, 0.0),
        solid=None,
        points_world_m=np.zeros((0, 3), np.float32),
        hist=None,
        n_observations=1,
        y0=y0,
        last_detection="d",
        last_step=0,
    )
