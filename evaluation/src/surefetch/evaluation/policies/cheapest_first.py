"""Look, the cheapest first, until the rules of commitment let a grasp through."""

from surefetch.common.joint_belief import JointBelief
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.evaluation.policies.observation import Observation
from surefetch.planner import actions


class CheapestFirst:
    """The paper's commitment without its planning."""

    def act(self, now: Observation) -> Choice:
        """The grasp that is eligible, else the cheapest look, else defer."""
        grasp = eligible(now)
        if grasp is not None:
            return grasp
        row = min(now.informs, key=lambda row: row.cost, default=None)
        return Defer() if row is None else Inform(name=row.name)


def eligible(now: Observation) -> Grasp | None:
    """The one grasp that the conformal set, the least belief for a grasp and the robot allow."""
    feasible = {verdict.track for verdict in now.feasibility.grasps if verdict.feasible}
    asked = now.target.relation
    belief = JointBelief.read(now.believed.belief)
    for candidate in actions.candidates(belief, asked, now.cover):
        sure = actions.semantically_eligible(
            candidate, now.believed.gamma, asked, now.parameters.commit_at_least
        )
        if sure and candidate.track in feasible:
            return Grasp(track=candidate.track, relation=candidate.relation)
    return None
