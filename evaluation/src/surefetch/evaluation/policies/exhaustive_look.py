"""Look at everything there is to see, then grasp if sure enough."""

from dataclasses import dataclass

from surefetch.common.messages import Choice, Inform
from surefetch.evaluation.policies.greedy import Greedy
from surefetch.evaluation.policies.observation import Observation


@dataclass(frozen=True)
class ExhaustiveLook:
    """Removes the cover if there is one, takes all views in tie order, then decides greedily."""

    at_least: float
    opens_for_outside: bool = True
    """False: the cover stays on when what stands outside is asked for."""

    def act(self, now: Observation) -> Choice:
        """The next look, and after the last the greedy end."""
        opens = self.opens_for_outside or now.target.relation != "outside"
        for row in now.informs:
            if opens or row.kind != "remove_cover":
                return Inform(name=row.name)
        return Greedy(self.at_least).act(now)
