"""The fixed order around the ports: what is dropped, grouped, asked."""

from collections.abc import Sequence

import numpy as np
import pytest
from rendered import ANYTHING, Shot, shoot
from tabletop import body, box, scene

from surefetch.common.mask import Bits, box_of
from surefetch.common.messages import Answers, FrameId, Target
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.perception.answers.scorer import ClassicalScorer
from surefetch.perception.candidate import Candidate, SceneView
from surefetch.perception.classical import VOCABULARY
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.observe import Perceived, observe
from surefetch.perception.ports import Backend, BoxPx, Proposal, Proposals
from surefetch.perception.reply import reply


class Listed:
    """Proposer and segmenter in one, that say what they are told to."""

    def __init__(self, masks: Sequence[tuple[float, Bits]], container: Bits | None) -> None:
        self._masks = [bits for _, bits in masks] + ([] if container is None else [container])
        regions = [Proposal(box_of(bits), score, "object") for score, bits in masks]
        whole = None if container is None else Proposal(box_of(container), 0.9, "box")
        self._proposals = Proposals(tuple(regions), whole)

    def propose(self, frame: RgbdFrame, target: Target) -> Proposals:
        return self._proposals

    def segment(self, frame: RgbdFrame, boxes: Sequence[BoxPx]) -> tuple[Bits, ...]:
        return tuple(self._masks)


class Counting:
    """A scorer that remembers who was asked about."""

    def __init__(self) -> None:
        self.asked: list[float] = []

    def score(
        self, scene: SceneView, candidates: Sequence[Candidate], target: Target
    ) -> tuple[Answers, ...]:
        self.asked += [candidate.score for candidate in candidates]
        return ClassicalScorer().score(scene, candidates, target)


@pytest.fixture(scope="module")
def shot() -> Shot:
    bodies = (body("a", at_m=(0.84, -0.15)), body("b", "ball", (0.05, 0.05, 0.048), (0.84, 0.15)))
    return shoot(scene(*bodies, container=box(covered=False)))


def see(
    shot: Shot, masks: Sequence[tuple[float, Bits]], container: Bits | None
) -> tuple[Perceived, Counting]:
    listed, scorer = Listed(masks, container), Counting()
    backend = Backend(VOCABULARY, listed, listed, scorer)
    return observe(shot.frame, ANYTHING, backend, LatestGeometry()), scorer


def shifted(bits: Bits, by: int) -> Bits:
    return np.roll(bits, by, axis=1)


def test_a_candidate_that_is_the_container_is_dropped(shot: Shot) -> None:
    a, container = shot.pixels_of(0), shot.pixels_of(-2)
    seen, _ = see(shot, [(0.9, container), (0.5, a)], container)
    assert [candidate.score for candidate in seen.scene.candidates] == [0.5]


def test_without_a_container_nothing_is_dropped(shot: Shot) -> None:
    seen, _ = see(shot, [(0.9, shot.pixels_of(-2)), (0.5, shot.pixels_of(0))], None)
    assert [candidate.score for candidate in seen.scene.candidates] == [0.9, 0.5]


def test_empty_masks_are_dropped(shot: Shot) -> None:
    nothing = np.zeros_like(shot.pixels_of(0))
    seen, _ = see(shot, [(0.9, nothing), (0.5, shot.pixels_of(0))], None)
    assert len(seen.scene.candidates) == 1


def test_the_same_body_twice_is_one_group_and_the_better_one_is_asked(shot: Shot) -> None:
    a, b = shot.pixels_of(0), shot.pixels_of(1)
    seen, scorer = see(shot, [(0.5, a), (0.7, b), (0.8, shifted(a, 1))], None)
    assert [candidate.score for candidate in seen.scene.candidates] == [0.8, 0.7, 0.5]
    assert seen.groups == (0, 1, 0)
    assert [answers is not None for answers in seen.answers] == [True, True, False]
    assert scorer.asked == [0.8, 0.7]


def test_bodies_that_overlap_a_little_are_two_groups(shot: Shot) -> None:
    a = shot.pixels_of(0)
    seen, _ = see(shot, [(0.5, a), (0.4, shifted(a, 12))], None)
    assert seen.groups == (0, 1)


def test_the_message_carries_every_detection_and_one_representative_a_group(shot: Shot) -> None:
    a, b = shot.pixels_of(0), shot.pixels_of(1)
    seen, _ = see(shot, [(0.5, a), (0.7, b), (0.8, shifted(a, 1))], shot.pixels_of(-2))
    told = reply(seen, FrameId(boot="boot", counter=4), "classical-1", duration_s=0.1)
    assert [detection.id for detection in told.detections] == ["boot/4/0", "boot/4/1", "boot/4/2"]
    for group in {detection.group for detection in told.detections}:
        own = [detection for detection in told.detections if detection.group == group]
        assert [detection.representative for detection in own] == [True] + [False] * (len(own) - 1)
        assert own[0].score == max(detection.score for detection in own)
    for detection in told.detections:
        assert detection.hist is not None
        assert sum(detection.hist) == pytest.approx(1.0)
        assert 0 < len(detection.points_world_m) <= 600


def test_a_mask_without_depth_has_no_centre_but_still_its_colour(shot: Shot) -> None:
    a = shot.pixels_of(0)
    depth = shot.frame.depth_m.copy()
    rows, columns = np.nonzero(a)
    depth[rows.min() - 8 : rows.max() + 8, columns.min() - 8 : columns.max() + 8] = 0
    blind = RgbdFrame(shot.frame.rgb, depth, shot.frame.K, shot.frame.T_world_camera)
    listed = Listed([(0.5, a)], None)
    backend = Backend(VOCABULARY, listed, listed, ClassicalScorer())
    asked = Target(noun="object", color="red", shape="cube", marking="plain")
    seen = observe(blind, asked, backend, LatestGeometry())
    (candidate,), (answers,) = seen.scene.candidates, seen.answers
    assert candidate.center_world_m is None
    assert candidate.solid is None
    assert candidate.hist is not None
    assert answers is not None
    assert answers.membership.label == "unknown"
    assert answers.shape is not None
    assert answers.shape.label == "unobservable"
