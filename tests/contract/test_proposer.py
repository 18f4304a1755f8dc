"""Every proposer keeps the port's promises."""

from collections.abc import Callable

import msgspec
import pytest
from rendered import Shot, shoot
from tabletop import BLUE, body, box, scene

from surefetch.common.mask import box_iou, box_of
from surefetch.common.messages import Target
from surefetch.perception.classical import classical_backend
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.ports import Proposer


def classical() -> Proposer:
    return classical_backend(LatestGeometry()).proposer


PROPOSERS: dict[str, Callable[[], Proposer]] = {"classical": classical}


@pytest.fixture(scope="module")
def table() -> Shot:
    cylinder = body("blue", "cylinder", (0.045, 0.045, 0.07), (0.84, 0.16))
    blue = msgspec.structs.replace(cylinder, rgb=BLUE)
    return shoot(scene(body("red", at_m=(0.84, -0.15)), blue, container=box(covered=False)))


@pytest.mark.parametrize("name", sorted(PROPOSERS))
@pytest.mark.parametrize("color", ["red", "blue"])
def test_what_is_asked_for_comes_first(name: str, color: str, table: Shot) -> None:
    asked = Target(noun="object", color=color)
    first = PROPOSERS[name]().propose(table.frame, asked).candidates[0]
    meant = table.pixels_of(["red", "blue"].index(color))
    assert box_iou(first.box_px, box_of(meant)) > 0.8


@pytest.mark.parametrize("name", sorted(PROPOSERS))
def test_scores_fall_and_lie_between_0_and_1(name: str, table: Shot) -> None:
    found = PROPOSERS[name]().propose(table.frame, Target(noun="object"))
    scores = [proposal.score for proposal in found.candidates]
    assert scores == sorted(scores, reverse=True)
    assert all(0.0 <= score <= 1.0 for score in scores)


@pytest.mark.parametrize("name", sorted(PROPOSERS))
def test_boxes_lie_in_the_image_and_hold_something(name: str, table: Shot) -> None:
    found = PROPOSERS[name]().propose(table.frame, Target(noun="object"))
    h, w = table.segmentation.shape
    assert found.candidates
    for proposal in found.candidates:
        x0, y0, x1, y1 = proposal.box_px
        assert 0 <= x0 < x1 <= w
        assert 0 <= y0 < y1 <= h


@pytest.mark.parametrize("name", sorted(PROPOSERS))
def test_the_container_is_no_candidate(name: str, table: Shot) -> None:
    found = PROPOSERS[name]().propose(table.frame, Target(noun="object"))
    assert found.container is not None
    truth = box_of(table.pixels_of(-2))
    assert box_iou(found.container.box_px, truth) > 0.9
    assert all(box_iou(proposal.box_px, truth) < 0.5 for proposal in found.candidates)


@pytest.mark.parametrize("name", sorted(PROPOSERS))
def test_the_same_frame_gives_the_same_proposals(name: str, table: Shot) -> None:
    asked = Target(noun="cube", shape="cube", color="red")
    assert PROPOSERS[name]().propose(table.frame, asked) == PROPOSERS[name]().propose(
        table.frame, asked
    )
