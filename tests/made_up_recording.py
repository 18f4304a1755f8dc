"""Parts of recordings that nobody recorded."""

import numpy as np
from scripted_table import BACKEND, CELL

from surefetch.common.messages import Observations
from surefetch.evaluation.recordings.free_space import SHAPE, FreeSpace
from surefetch.evaluation.recordings.recording import MadeWith, Shot, State

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
    )


def shot(state: State, observations: Observations) -> Shot:
    """A state in which the camera stands nowhere."""
    return Shot(
        state=state,
        observations=observations,
        K=np.eye(3),
        T_world_camera=np.eye(4),
        free_space=NOTHING_SEEN,
    )
