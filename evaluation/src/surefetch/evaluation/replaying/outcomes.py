"""What comes of an action, with common random numbers: the same for everybody who tries it. Pure.

An outcome is addressed by action, body and attempt, never by time: two policies that grasp a body
for the first time share what comes of it, however long each looked before.
"""

from dataclasses import dataclass

from surefetch.common.cell import InformRow
from surefetch.common.streams import stream
from surefetch.evaluation.fitting.gates import P_GRASP, P_REMOVE, P_VIEW

NO_BODY = "-"


@dataclass(frozen=True)
class Rates:
    """True chances that the three kinds of interaction succeed."""

    remove: float = P_REMOVE
    view: float = P_VIEW
    grasp: float = P_GRASP


@dataclass(frozen=True)
class Outcomes:
    """The outcomes of one scene, drawn independently (`bernoulli`)."""

    family: str
    seed: int
    rates: Rates
    draw: int = 0
    """Which of many independent draws for the same scene."""

    def informs(self, row: InformRow, attempt: int) -> bool:
        """Whether this try, counted from 1, of an information action succeeds."""
        p = self.rates.remove if row.kind == "remove_cover" else self.rates.view
        return self._draw(row.name, NO_BODY, attempt) < p

    def grasps(self, body: str | None, attempt: int) -> bool:
        """Whether this try to grasp a body succeeds; where no body is, never."""
        return body is not None and self._draw("grasp", body, attempt) < self.rates.grasp

    def _draw(self, action: str, body: str, attempt: int) -> float:
        again = () if self.draw == 0 else (self.draw,)
        rng = stream(self.family, self.seed, "outcome", action, body, attempt, *again)
        return float(rng.random())
