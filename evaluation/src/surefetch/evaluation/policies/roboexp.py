"""RoboEXP (no LLM): explore what hides something, and build the scene graph as it appears.

The published system explores without a goal: for each object a multimodal language model picks
*open*, *pick up* or *no action*, by what the object may hide. Actions form a stack, the last found
first; before opening, objects within 0.2 m of the handle are picked away; exploration ends with an
empty stack. It takes no viewpoint on purpose, fetches no target and never abstains.

Source: Jiang et al., RoboEXP: Action-Conditioned Scene Graph via Interactive Exploration for
Robotic Manipulation (2024), and its public code.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import Choice, Defer, Inform, Track
from surefetch.evaluation.policies.matching import (
    AT_LEAST,
    category,
    commit,
    grasp,
    grip_on,
    is_match,
    is_unread,
    relation_of,
)
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.tuning import Scalar
from surefetch.evaluation.policies.unseen import Outlook
from surefetch.evaluation.policies.voxels import VOXEL_L, Marks

SCALARS: Final = (AT_LEAST, Scalar("hidden_l", (0.02, 0.05, 0.1, 0.2, 1.0)))


class RoboExpLite:
    """Opens what is covered; then grasps the best match in the order of the graph.

    Kept are the order, graph by graph level, and that it always answers. The language model is
    replaced by the rule that a covered container opens. The target is looked up among the latest
    categories.
    """

    def act(self, now: Observation) -> Choice:
        """Open, grasp the first of the best rank, or defer if nothing can be grasped."""
        opens = next((row for row in now.informs if row.kind == "remove_cover"), None)
        if now.cover == "covered" and opens is not None:
            return Inform(name=opens.name)
        grips = [(track, grip_on(now, track)) for track in _in_graph_order(now.believed.tracks)]
        ranked = [
            (_rank(category(track), now.target.relation), grip)
            for track, grip in grips
            if grip is not None
        ]
        if not ranked:
            return Defer()
        return grasp(min(ranked, key=lambda one: one[0])[1])


def _in_graph_order(tracks: tuple[Track, ...]) -> list[Track]:
    """Children of the table, then of the container, the older first."""
    return sorted(tracks, key=lambda t: (relation_of(category(t)) == "inside", t.id))


def _rank(y: str, asked: AskedRelation) -> int:
    """0 for what fits, then what may fit, at last what does not."""
    stands = relation_of(y)
    if is_match(y, asked):
        return 0
    if y == "MU":
        return 1
    if y.startswith("U") and (stands is None or asked in ("any", stands)):
        return 3 if stands is None else 2
    return 4 if stands is not None else 5


@dataclass(frozen=True, eq=False)
class _Promise:
    """A view, and what it is predicted to reveal."""

    action: str
    reveals: Marks


@dataclass(frozen=True)
class _Item:
    """An action on the stack, and the track for which it is there; None: the cover."""

    action: str
    track: int | None


@dataclass
class RoboExpStrong:
    """Explores until nothing is left to explore, then asks the shared belief.

    Kept is the stack, depth first. The language model's choice is replaced by a rule: a covered
    container opens; a track of which an asked part is unread, or which hides unseen volume, gets
    the view that reveals most of that, in the place of picking it away; else nothing. Abstention
    is added.
    """

    at_least: float = 0.5
    """τ: least belief at which is grasped."""
    hidden_l: float = 0.2
    """U_min: unseen volume behind a track, in litres, that is worth a look."""
    _stack: list[_Item] = field(default_factory=list, init=False, repr=False)

    def act(self, now: Observation) -> Choice:
        """The newest action on the stack; grasp or defer when it is empty."""
        reasons = self._reasons(now)
        is_open = {row.name for row in now.informs}
        kept = [i for i in self._stack if i.action in is_open and i.track in reasons]
        waiting = {item.track for item in kept}
        new = [_Item(action, track) for track, action in reasons.items() if track not in waiting]
        self._stack = kept + new
        if self._stack:
            return Inform(name=self._stack.pop().action)
        return commit(now, self.at_least)

    def _reasons(self, now: Observation) -> dict[int | None, str]:
        """What there is to explore, and the action that serves it best; the cover is first."""
        outlook = Outlook(now)
        opens = [(None, row.name) for row in now.informs if row.kind == "remove_cover"]
        found: dict[int | None, str] = dict(opens)
        views = [
            _Promise(row.name, outlook.revealed(row)) for row in now.informs if row.kind == "view"
        ]
        for track in now.believed.tracks if views else ():
            view = self._view_for(track, outlook, views)
            found |= {} if view is None else {track.id: view}
        return found

    def _view_for(self, track: Track, outlook: Outlook, views: Sequence[_Promise]) -> str | None:
        """The view that reveals most of what a track hides; None: it hides nothing of interest."""
        region = outlook.behind(track)
        unread = is_unread(category(track), outlook.now.target.relation)
        if not unread and len(region) * VOXEL_L < self.hidden_l:
            return None
        if unread:
            region = np.union1d(region, outlook.about(track))
        best = max(views, key=lambda view: (view.reveals[region].sum(), view.reveals.sum()))
        return best.action if unread or best.reveals[region].any() else None
