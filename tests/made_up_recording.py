"""Parts of recordings that nobody recorded."""

from collections.abc import Sequence

import numpy as np
from scripted_table import BACKEND, CELL

from surefetch.common.messages import Feasibility, GraspVerdict, Observations
from surefetch.evaluation.recordings.free_space import SHAPE, FreeSpace
from surefetch.evaluation.recordings.histories import histories, known_after
from surefetch.evaluation.recordings.recording import FeasibleAfter, MadeWith, Shot, State

NOTHING_SEEN = FreeSpace.of(np.zeros(SHAPE, np.int8))


def made_with(backend: str = BACKEND) -> MadeWith:
    """By nothing in particular."""
    return MadeWith(
        surefetch="0",
        generator_version=1,
        generator="made-up",
        cell=CELL.name,
        cell_file="made-up",
        backend=backend,
        perception="made-up",
        planning="made-up",
    )


def shot(state: State, observations: Observations) -> Shot:
    """A state in which the camera stands nowhere."""
    return Shot(
        state=state,
        observations=observations,
        K=np.eye(3),
        T_world_camera=np.eye(4),
        q_rad=(0.0,) * 6,
        free_space=NOTHING_SEEN,
    )


def all_feasible(shots: Sequence[Shot], *, covered: bool) -> tuple[FeasibleAfter, ...]:
    """Every track can be grasped after every history of these shots, and every view reached."""
    seen = {shot.state: shot.observations for shot in shots}
    return tuple(
        FeasibleAfter(
            looks=looks,
            feasibility=Feasibility(
                grasps=tuple(
                    GraspVerdict(track=t.id, feasible=True, refusal=None, why="", tried={})
                    for t in known_after((state.view, seen[state]) for state in looks).tracks
                ),
                informs=(),
                duration_s=0.0,
            ),
            informs_s={},
            grasps_s={},
        )
        for looks in histories(covered, CELL)
    )
