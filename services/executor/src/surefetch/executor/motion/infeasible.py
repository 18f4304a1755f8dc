"""The robot's "no": which check refused, and why, in words."""

from surefetch.common.errors import SurefetchError
from surefetch.common.messages import Refusal


class Infeasible(SurefetchError):
    """A pose or motion that the robot refuses. Nothing was moved."""

    def __init__(self, refusal: Refusal, why: str) -> None:
        super().__init__(why)
        self.refusal: Refusal = refusal
        self.why = why
