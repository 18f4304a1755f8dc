"""One frame and a target in, everything that can be said about it out. Pure.

The order is fixed and the same for every back-end: propose, segment, drop what is the container,
group what is the same, lift, ask.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from surefetch.common import mask
from surefetch.common.mask import Bits
from surefetch.common.messages import Answers, Target
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.perception import obstacles
from surefetch.perception.candidate import Candidate, SceneView
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.lifting import candidate_of
from surefetch.perception.obstacles import Obstacles
from surefetch.perception.ports import Backend, Proposal

CONTAINER_IOU: Final = 0.5
SAME_IOU: Final = 0.75


@dataclass(frozen=True, eq=False)
class Perceived:
    """A frame understood: the scene, groups of candidates, and answers about one of each group."""

    scene: SceneView
    groups: tuple[int, ...]
    """Of each candidate of the scene; the first of a group represents it"""
    answers: tuple[Answers | None, ...]
    """None for those that do not represent their group"""
    obstacles: Obstacles


def observe(
    frame: RgbdFrame, target: Target, backend: Backend, geometry: LatestGeometry
) -> Perceived:
    """Perceive a frame with a target in mind.

    Raises:
        NoSupport: nothing in view that things could stand on.
    """
    found = geometry.of(frame)
    proposals = backend.proposer.propose(frame, target)
    regions = [*proposals.candidates, *([proposals.container] if proposals.container else [])]
    masks = backend.segmenter.segment(frame, [region.box_px for region in regions])
    container_bits = masks[-1] if proposals.container else None
    kept = _kept(list(zip(proposals.candidates, masks, strict=False)), container_bits)
    groups = _grouped([bits for _, bits in kept])
    lifted = geometry.lifted(frame, [bits for _, bits in kept])
    candidates = tuple(
        candidate_of(proposal, bits, body)
        for (proposal, bits), body in zip(kept, lifted, strict=True)
    )
    scene = SceneView(found.surface, found.container, container_bits, candidates)
    return Perceived(
        scene,
        groups,
        _asked(scene, groups, target, backend),
        obstacles.find(scene, found.foreground),
    )


def _kept(
    masked: Sequence[tuple[Proposal, Bits]], container: Bits | None
) -> list[tuple[Proposal, Bits]]:
    """What shows something and is not the container, best score first."""
    kept = [
        (proposal, bits)
        for proposal, bits in masked
        if bits.any() and (container is None or mask.iou(bits, container) < CONTAINER_IOU)
    ]
    return sorted(kept, key=lambda pair: -pair[0].score)


def _grouped(masks: Sequence[Bits]) -> tuple[int, ...]:
    """Group of each mask; a mask joins the first group whose first member it matches."""
    overlaps = mask.iou_matrix(masks, masks)
    leaders: list[int] = []
    groups: list[int] = []
    for i in range(len(masks)):
        group = next((g for g, j in enumerate(leaders) if overlaps[i, j] >= SAME_IOU), None)
        if group is None:
            group = len(leaders)
            leaders.append(i)
        groups.append(group)
    return tuple(groups)


def _asked(
    scene: SceneView, groups: Sequence[int], target: Target, backend: Backend
) -> tuple[Answers | None, ...]:
    first = {group: i for i, group in reversed(list(enumerate(groups)))}
    leaders = sorted(first.values())
    asked: Sequence[Candidate] = [scene.candidates[i] for i in leaders]
    answers = dict(zip(leaders, backend.scorer.score(scene, asked, target), strict=True))
    return tuple(answers.get(i) for i in range(len(groups)))
