"""Is a recording what the same scene would give again? A few scenes are looked at twice to tell.

Source: EVALUATION section 2.4, the row on renderers that are not deterministic.
"""

from collections.abc import Iterable, Sequence
from itertools import zip_longest
from typing import Final

from surefetch.common.errors import InfrastructureError
from surefetch.common.messages import Detection
from surefetch.common.observations import observation_of
from surefetch.common.streams import stream
from surefetch.evaluation.recordings.recording import Repeated, Shot

SHARE: Final = 0.02
"""Of all scenes is looked at twice."""
MOST_DIFFERING: Final = 0.005


def is_repeated(family: str, seed: int) -> bool:
    """Whether this scene is one of those."""
    return bool(stream(family, seed, "camera", "repeated").random() < SHARE)


def compared(first: Sequence[Shot], again: Sequence[Shot]) -> Repeated:
    """How many candidates were put in another category when all states were seen again."""
    n, differing = 0, 0
    for one, other in zip(first, again, strict=True):
        pairs = zip_longest(one.observations.detections, other.observations.detections)
        told = [(_category(a), _category(b)) for a, b in pairs]
        n += len(told)
        differing += sum(a != b for a, b in told)
    return Repeated(candidates=n, differing=differing)


def check(found: Iterable[Repeated]) -> Repeated:
    """The sum.

    Raises:
        InfrastructureError: too many differ for one recording to stand for what all policies see.
    """
    counted = list(found)
    n, differing = sum(r.candidates for r in counted), sum(r.differing for r in counted)
    if differing > MOST_DIFFERING * n:
        raise InfrastructureError(
            f"{differing} of {n} candidates were put in another category when their scene was "
            f"perceived again; at most {100 * MOST_DIFFERING:.1f} % may be. Rendering or "
            "perception is not deterministic here, so one recording cannot stand for all runs."
        )
    return Repeated(candidates=n, differing=differing)


def _category(detection: Detection | None) -> str:
    """Also told apart: not there, and not asked about."""
    if detection is None:
        return "missing"
    return "unanswered" if detection.answers is None else observation_of(detection.answers)
