"""ActPerMoMa: look where unseen space is, until a grasp within reach is seen well enough.

In the published system the place and the bounding box of the target are given. It moves to the
view of the largest sum of information gain, weighted 0.5, and reachability of stable grasps; gain
counts the unseen voxels just behind surfaces in that box. Grasps count once the views span 45° of
azimuth. Which object it is, is no question, nothing is opened and nothing is deferred.

Grasps are those of the shared feasibility check; there is no learned grasp network. Momentum and
deadlock rules have no meaning with few fixed views and are dropped, as are the views' upper limit
and the weight of reachability: from a fixed base a grasp is within reach after one view as after
another, so that it moves no choice between views.

Source: Jauhri et al., Active-Perceptive Motion Generation for Mobile Manipulation (2024), and its
public code.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import RELATIONS, UNOBS, Relation, tracked
from surefetch.common.messages import Choice, Defer, Inform, Track
from surefetch.evaluation.policies.matching import (
    AT_LEAST,
    category,
    commit,
    grasp,
    grip_on,
    is_match,
    suiting,
)
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.tuning import Scalar
from surefetch.evaluation.policies.unseen import Outlook, views_taken
from surefetch.evaluation.policies.voxels import N_VOXELS, Marks, Voxels
from surefetch.evaluation.recordings.free_space import FILLED, SHAPE

Weights = NDArray[np.float64]
"""(voxels,)"""

COVERED_DEG: Final = 45.0
"""Azimuth that the views must span. Published value."""
GAIN_WEIGHT: Final = 0.5
"""Published value."""


SCALARS: Final = (AT_LEAST, Scalar("min_gain", (-0.15, -0.1, -0.05, 0.0, 0.02)))


class ActPerMoMaLite:
    """Looks until the views span 45° and a match can be grasped; grasps a match in the last frame.

    Kept are the gain, the span, and that covers are no actions. The given target is replaced by
    the tracks whose latest category is a match, its box by the recorded space. Abstention, where
    there is none, is added.
    """

    def act(self, now: Observation) -> Choice:
        """The view of the largest gain, or a grasp, or defer."""
        matches = [
            (track, grip)
            for track in now.believed.tracks
            if is_match(category(track), now.target.relation)
            and (grip := grip_on(now, track)) is not None
        ]
        views = [row for row in now.informs if row.kind == "view"]
        if views and (span_deg(now) < COVERED_DEG or not matches):
            return Inform(name=_of_largest_gain(now, views).name)
        in_frame = [(t, grip) for t, grip in matches if t.last_step == now.believed.step]
        best = min(in_frame, key=lambda one: _refusals(now, one[0]), default=None)
        return Defer() if best is None else grasp(best[1])


def _of_largest_gain(now: Observation, views: list[InformRow]) -> InformRow:
    if len(views) == 1:
        return views[0]
    outlook, behind = Outlook(now), _behind_surfaces(now)
    return max(views, key=lambda row: (outlook.revealed(row) & behind).sum())


def span_deg(now: Observation) -> float:
    """Azimuth that the views so far span."""
    at_deg = [view.azimuth_deg for view in views_taken(now)]
    return max(at_deg) - min(at_deg)


def _behind_surfaces(now: Observation) -> Marks:
    """Voxels one step from one that was seen filled; those in front of it were seen free."""
    filled = now.free_space == FILLED
    near = np.zeros(SHAPE, np.bool_)
    for axis in range(len(SHAPE)):
        at, along = np.moveaxis(near, axis, 0), np.moveaxis(filled, axis, 0)
        at[1:] |= along[:-1]
        at[:-1] |= along[1:]
    return near.ravel()


def _refusals(now: Observation, track: Track) -> int:
    """Grasps that were refused before one was found; the fewer, the better stands the best."""
    verdict = next(v for v in now.feasibility.grasps if v.track == track.id)
    return sum(verdict.tried.values())


@dataclass(frozen=True)
class ActPerMoMaStrong:
    """Acts where the target, or what may be it, is expected unseen, while that pays; then commits.

    Kept are gain over cost, its weight, the span of views at which looking ends, and commitment to
    grasps within reach. The given box is replaced by where the shared belief expects an unseen
    target, and by bodies that may be it. Removing a cover is a view of the container's inside.
    Abstention is added.
    """

    at_least: float = 0.5
    """τ: least belief at which is grasped."""
    min_gain: float = 0.0
    """Least score of an action that is worth it. The published 25 voxels are of another grid."""

    def act(self, now: Observation) -> Choice:
        """The action of the largest score; grasp or defer when that is too small."""
        if now.informs and span_deg(now) < COVERED_DEG:
            outlook = Outlook(now)
            weight = expected(outlook)
            scores = {
                row.name: GAIN_WEIGHT * weight[outlook.revealed(row)].sum() - row.cost
                for row in now.informs
            }
            best = max(scores, key=lambda name: scores[name])
            if scores[best] > self.min_gain:
                return Inform(name=best)
        return commit(now, self.at_least)


def expected(outlook: Outlook) -> Weights:
    """w(x): where there may be something of the target to see.

    The mass of an unseen target spread over the unseen voxels by the asked relation; and of each
    track how undecided it is, 4 b (1 - b), spread over the unseen voxels about its box.
    """
    now, weight = outlook.now, np.zeros(N_VOXELS)
    for relation, share in _shares(now).items():
        region = np.flatnonzero(outlook.unseen & (outlook.inside == (relation == "inside")))
        _spread(weight, now.believed.belief[UNOBS] * share, region)
    for track in now.believed.tracks:
        p = _mass(now, track)
        _spread(weight, 4.0 * p * (1.0 - p), outlook.about(track))
    return weight


def _shares(now: Observation) -> dict[Relation, float]:
    """How an unseen target stands: as asked, or else by the prior."""
    asked = now.target.relation
    if asked == "any":
        prior = now.parameters.belief_priors(asked, covered=now.cover == "covered").relation
        return {relation: prior[relation] for relation in RELATIONS}
    return {relation: float(relation == asked) for relation in RELATIONS}


def _mass(now: Observation, track: Track) -> float:
    """Belief that a track is the target, standing as asked."""
    belief = now.believed.belief
    return sum(belief[tracked(track.id, stands)] for stands in suiting(now.target.relation))


def _spread(weight: Weights, mass: float, voxels: Voxels) -> None:
    if len(voxels):
        weight[voxels] += mass / len(voxels)
