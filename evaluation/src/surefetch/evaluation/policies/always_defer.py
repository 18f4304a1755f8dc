"""Never commit."""

from surefetch.common.messages import Choice, Defer
from surefetch.evaluation.policies.observation import Observation


class AlwaysDefer:
    """Right exactly when nothing is there."""

    def act(self, _: Observation) -> Choice:
        """Defer."""
        return Defer()
