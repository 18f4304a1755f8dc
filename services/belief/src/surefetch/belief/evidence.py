"""What a detection's answers say of its track: the port, and the paper's seven categories. Pure."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from surefetch.common.emission import Emission
from surefetch.common.hypotheses import OBSERVATIONS
from surefetch.common.messages import Answers

Array = NDArray[np.float64]

Known = tuple[float, ...]
"""What has been learnt of one track besides the belief, in whatever form the evidence keeps it.
Empty for a track that was never observed."""
NOTHING: Known = ()


@dataclass(frozen=True)
class Seen:
    """One detection after association; y is None where it carries no observation."""

    id: str
    track: int
    y: str | None
    answers: Answers | None = None
    """What y was made of, where it is known."""


@dataclass(frozen=True, eq=False)
class Weighed:
    """What one counted observation says."""

    likelihood: Array
    """(classes,) of the observation, if the track is the target inside, outside, or none."""
    known: Known
    """Of the track, the observation included."""
    absence: float = 1.0
    """How much likelier the observation is where the target is absent than where it is another
    track, or not seen."""


Weigh = Callable[[Seen, Known], Weighed]
"""One counted observation, and what was known of its track before."""


class Evidence(Protocol):
    """How likely answers are, by what the track is."""

    def under(self, q: str) -> Weigh:
        """The weighing of observations from one viewing condition, also one never fitted."""
        ...


@dataclass(frozen=True, eq=False)
class CategoryEvidence:
    """The four answers as one of seven observations; each look tells anew.

    Source: paper, eq:event-alphabet, eq:pooled-emission.
    """

    emission: Emission

    def under(self, q: str) -> Weigh:
        """E(y | q, c)."""
        by_class = self.emission.likelihood(q)

        def weigh(seen: Seen, known: Known) -> Weighed:
            assert seen.y is not None, "an observation without y never counts"
            return Weighed(by_class[:, OBSERVATIONS.index(seen.y)], known)

        return weigh
