"""DovSG (no LLM): subtasks planned from the sentence, over a memory of what was seen.

In the published system a language model turns the sentence, once, into *go to*, *pick up* and
*place*; a scene graph is built and updated beside it. A description is localised as the one of the
best visual matches that is nearest to the named neighbour, by centroids, and there is always an
answer. Memory is updated from newer depth; a step that fails ends the run. Nothing is opened, no
viewpoint is taken to find out more, and nothing is deferred.

Source: Yan et al., Dynamic Open-Vocabulary 3D Scene Graphs for Long-term Language-Guided Mobile
Manipulation (2024). Written from the publication and the observed behaviour; the code has no
licence.
"""

from dataclasses import dataclass, field

import numpy as np

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import Choice, Defer, Inform, Track
from surefetch.evaluation.policies.matching import category, grasp, grip_on, is_match, is_unread
from surefetch.evaluation.policies.object_memory import Node, graph
from surefetch.evaluation.policies.observation import Grip, Observation
from surefetch.evaluation.policies.unseen import Outlook


@dataclass
class DovSgLite:
    """Locates in the first look and in one more, then picks; the plan is fixed by the sentence.

    Kept are the plan made once, the choice by nearness to the named container, and that nothing
    is opened. The language model is replaced by this one plan, visual matches by the latest
    categories. Abstention, where nothing was found, is added.
    """

    _went: bool = field(default=False, init=False, repr=False)

    def act(self, now: Observation) -> Choice:
        """Pick what is located; else take the second look; else defer."""
        found = _located(now)
        if found is not None:
            return grasp(found)
        view = next((row for row in now.informs if row.kind == "view"), None)
        if view is None or self._went:
            return Defer()
        self._went = True
        return Inform(name=view.name)


def _located(now: Observation) -> Grip | None:
    """Of the matches that can be grasped the one nearest to the container, the older of equals."""
    container = now.estimate.container

    def away_m(track: Track) -> float:
        if container is None:
            return 0.0
        apart = np.subtract(track.center_world_m, container.outer.center_world_m)
        return float(np.linalg.norm(apart))

    for track in sorted(now.believed.tracks, key=away_m):
        grip = grip_on(now, track)
        if grip is not None and is_match(category(track), now.target.relation):
            return grip
    return None


@dataclass(frozen=True)
class DovSgStrong:
    """Plans from the sentence and the graph, and plans again when a subtask's result fails.

    Kept are the memory, its deletion by newer depth, the edge by the container's hull, subtasks
    and their order. Labels are the marginals of the shared belief. The language model is replaced
    by a template: confirm unknown nodes, open if the target is asked for inside or was not found,
    locate, pick. Views, opening and abstention are added.
    """

    at_least: float = 0.5
    """τ: least belief at which is picked, and at which a label is known."""

    def act(self, now: Observation) -> Choice:
        """The first subtask whose result is missing and whose action is open; at last pick."""
        nodes = graph(now)
        asked = [node for node in nodes if now.target.relation in ("any", node.edge)]
        is_found = sum(node.p >= self.at_least for node in asked) == 1
        unknown = [node for node in nodes if not self._is_known(node, now.target.relation)]
        if unknown or not is_found:
            views = [row for row in now.informs if row.kind == "view"]
            if views:
                return Inform(name=_view_of(now, views, unknown).name)
        if now.target.relation == "inside" or not is_found:
            for row in now.informs:
                if row.kind == "remove_cover":
                    return Inform(name=row.name)
        return self._pick(now, asked)

    def _is_known(self, node: Node, asked: AskedRelation) -> bool:
        is_read = not is_unread(category(node.track), asked)
        return is_read and node.confirmed and max(node.p, 1.0 - node.p) >= self.at_least

    def _pick(self, now: Observation, asked: list[Node]) -> Choice:
        best = max(asked, key=lambda node: node.p, default=None)
        if best is None or best.p < self.at_least:
            return Defer()
        grip = grip_on(now, best.track, best.edge)
        return Defer() if grip is None else grasp(grip)


def _view_of(now: Observation, views: list[InformRow], unknown: list[Node]) -> InformRow:
    """The view that reveals most about unknown nodes; of equals the one that reveals most."""
    if len(views) == 1:
        return views[0]
    outlook = Outlook(now)
    faces = [outlook.about(node.track) for node in unknown]

    def promise(row: InformRow) -> tuple[int, int]:
        reveals = outlook.revealed(row)
        return sum(int(reveals[voxels].sum()) for voxels in faces), int(reveals.sum())

    return max(views, key=promise)
