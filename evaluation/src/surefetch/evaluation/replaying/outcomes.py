"""What comes of an action, with common random numbers: the same for everybody who tries it. Pure.

An outcome is addressed by action, body and attempt, never by time: two policies that grasp a body
for the first time share what comes of it, however long each looked before.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, Protocol, get_args

from surefetch.common.cell import InformRow
from surefetch.common.streams import stream
from surefetch.evaluation.fitting.gates import P_GRASP, P_REMOVE, P_VIEW
from surefetch.evaluation.recordings.measured import Attempt, Measured

Mode = Literal["measured", "bernoulli"]
MODES: Final[tuple[Mode, ...]] = get_args(Mode)
NO_BODY: Final = "-"


@dataclass(frozen=True)
class Outcome:
    """What came of one attempt."""

    done: bool
    duration_s: float = 0.0
    """Modelled; 0 where nobody knows."""
    why: str = ""
    disturbance: Attempt | None = None
    """It failed, and moved bodies so far that the recording no longer holds; as measured."""


class NotMeasured(Exception):
    """Nobody tried this."""


class Outcomes(Protocol):
    """The outcomes of one scene."""

    def informs(self, row: InformRow, attempt: int) -> Outcome:
        """Of this try, counted from 1, of an information action. Raises NotMeasured."""
        ...

    def grasps(self, body: str | None, attempt: int) -> Outcome:
        """Of this try to grasp a body; where no body is, it fails. Raises NotMeasured."""
        ...


@dataclass(frozen=True)
class Rates:
    """True chances that the three kinds of interaction succeed."""

    remove: float = P_REMOVE
    view: float = P_VIEW
    grasp: float = P_GRASP


@dataclass(frozen=True)
class Drawn:
    """Outcomes drawn independently (`bernoulli`); a failure moves nothing."""

    family: str
    seed: int
    rates: Rates
    draw: int = 0
    """Which of many independent draws for the same scene."""

    def informs(self, row: InformRow, attempt: int) -> Outcome:
        """See `Outcomes.informs`."""
        p = self.rates.remove if row.kind == "remove_cover" else self.rates.view
        return Outcome(self._uniform(row.name, NO_BODY, attempt) < p)

    def grasps(self, body: str | None, attempt: int) -> Outcome:
        """See `Outcomes.grasps`."""
        there = body is not None
        return Outcome(there and self._uniform("grasp", body or "", attempt) < self.rates.grasp)

    def _uniform(self, action: str, body: str, attempt: int) -> float:
        again = () if self.draw == 0 else (self.draw,)
        rng = stream(self.family, self.seed, "outcome", action, body, attempt, *again)
        return float(rng.random())


@dataclass(frozen=True)
class AsMeasured:
    """Removals and grasps of the target as they came out in the simulator (`measured`).

    A view that is feasible succeeds. Grasps of other bodies, which are wrong anyway, are drawn.
    """

    measured: Measured
    target: str | None
    others: Drawn

    def informs(self, row: InformRow, attempt: int) -> Outcome:
        """See `Outcomes.informs`."""
        if row.kind == "remove_cover":
            return _nth(self.measured.removals, attempt)
        return Outcome(True)

    def grasps(self, body: str | None, attempt: int) -> Outcome:
        """See `Outcomes.grasps`."""
        if body is None or body != self.target:
            return self.others.grasps(body, attempt)
        return _nth(self.measured.grasps, attempt)


def _nth(attempts: Sequence[Attempt], n: int) -> Outcome:
    if n > len(attempts):
        raise NotMeasured
    one = attempts[n - 1]
    disturbs = not one.done and one.disturbed
    return Outcome(one.done, one.duration_s, one.why, one if disturbs else None)
