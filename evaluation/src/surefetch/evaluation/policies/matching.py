"""How the baselines read categories and belief, and what they make of them. Pure."""

from typing import Final

from surefetch.common.hypotheses import RELATIONS, AskedRelation, Relation, tracked
from surefetch.common.messages import Choice, Defer, Grasp, Track
from surefetch.evaluation.policies.observation import Grip, Observation
from surefetch.evaluation.policies.tuning import Scalar
from surefetch.planner.actions import compatible_with

AT_LEAST: Final = Scalar("at_least", (0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.7, 0.8, 0.9))
"""τ, the least belief at which is grasped, where a second number is tuned with it."""
UNREAD: Final = "UU"
"""Of a track that was never observed."""
_RELATION: Final[dict[str, Relation]] = {"I": "inside", "O": "outside"}


def category(track: Track) -> str:
    """lab(i): the latest one of seven."""
    return track.y0 or UNREAD


def relation_of(y: str) -> Relation | None:
    """How a category says that its track stands; None where it does not."""
    return _RELATION.get(y[1:])


def is_match(y: str, asked: AskedRelation) -> bool:
    """M*: every attribute as asked, and the relation too if one was."""
    return y.startswith("M") and (asked == "any" or relation_of(y) == asked)


def is_unread(y: str, asked: AskedRelation) -> bool:
    """Whether something that the instruction names could not be seen."""
    return y.startswith("U") or (y == "MU" and asked != "any")


def suiting(asked: AskedRelation) -> list[Relation]:
    """The relations that the instruction allows."""
    allowed = zip(RELATIONS, compatible_with(asked), strict=True)
    return [relation for relation, suits in allowed if suits]


def grip_on(now: Observation, track: Track, stands: Relation | None = None) -> Grip | None:
    """The open grasp of a track, in this relation where that is open; or else the likelier one.

    Without a relation, that of its category.
    """
    wanted = stands or relation_of(category(track))
    grips = [grip for grip in now.grasps if grip.track == track.id]
    return min(grips, key=lambda grip: grip.relation != wanted, default=None)


def grasp(grip: Grip) -> Grasp:
    """As an action."""
    return Grasp(track=grip.track, relation=grip.relation)


def best(now: Observation) -> Grip | None:
    """The hypothesis with a track that suits the instruction and is believed most."""
    belief = now.believed.belief
    relations = suiting(now.target.relation)
    grips = [
        Grip(track.id, relation, belief[tracked(track.id, relation)])
        for track in now.believed.tracks
        for relation in relations
    ]
    return max(grips, key=lambda grip: grip.p, default=None)


def commit(now: Observation, at_least: float) -> Choice:
    """Grasp what is believed most if that is enough and possible, or else defer."""
    found = best(now)
    sure = found is not None and found.p >= at_least and found in now.grasps
    return grasp(found) if sure and found is not None else Defer()
