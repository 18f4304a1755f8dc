"""Whether a body is in the reference container. Pure."""

from typing import Final

import numpy as np

from surefetch.common.messages import Answer
from surefetch.perception.answers.answer import membership as answer
from surefetch.perception.candidate import Candidate
from surefetch.perception.container import Container

UNIT_M: Final = 0.010
UNKNOWN: Final = 0.5
"""A centre within 5 mm of the edge is unknown."""


def membership(candidate: Candidate, container: Container | None) -> Answer:
    """By the signed distance of the body's centre to the inner edge."""
    if container is None or not container.complete or candidate.center_world_m is None:
        return answer(0.0, 1.0, {"container": float(container is not None)})
    xy = np.array(candidate.center_world_m[:2])
    inset = float(container.inner.inset(xy))
    evidence = {"inset_m": inset, "lid": float(container.lid is not None)}
    if container.lid is not None:  # nothing inside can be seen
        return answer(-1.0, UNKNOWN, evidence)
    return answer(inset / UNIT_M, UNKNOWN, evidence)
