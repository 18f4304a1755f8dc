"""Inside is within the inner walls of an open container that is wholly seen."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.perception.answers.membership import membership
from surefetch.perception.candidate import Candidate
from surefetch.perception.container import Container, Lid
from surefetch.perception.rectangle import Rectangle

NOTHING = np.zeros((4, 4), dtype=np.bool_)
INNER = Rectangle(0.0, (0.9, 1.1), (-0.08, 0.08))
OUTER = Rectangle(0.0, (0.895, 1.105), (-0.085, 0.085))
BOX = Container(OUTER, INNER, 0.07, 0.004, None, NOTHING, True, 0.95)


def standing_at(x: float, y: float) -> Candidate:
    return Candidate(
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=0.9,
        phrase="",
        bits=NOTHING,
        core=NOTHING,
        n_px=400,
        occluded_share=0.0,
        border_share=0.0,
        on_container_floor=False,
        base_m=0.0,
        center_world_m=(x, y, 0.03),
        solid=None,
    )


@settings(deadline=None)
@given(st.floats(0.7, 1.3), st.floats(-0.3, 0.3))
def test_centres_within_are_inside_beyond_outside_and_on_the_edge_unknown(
    x: float, y: float
) -> None:
    inset = min(0.1 - abs(x - 1.0), 0.08 - abs(y))
    label = membership(standing_at(x, y), BOX).label
    if inset > 0.0051:
        assert label == "inside"
    elif inset < -0.0051:
        assert label == "outside"
    elif abs(inset) < 0.0049:
        assert label == "unknown"


@pytest.mark.parametrize("container", [None, replace(BOX, complete=False)], ids=["none", "cut"])
def test_without_a_whole_container_nobody_knows(container: Container | None) -> None:
    assert membership(standing_at(1.0, 0.0), container).label == "unknown"


def test_a_body_without_depth_is_nowhere() -> None:
    nowhere = replace(standing_at(1.0, 0.0), center_world_m=None)
    assert membership(nowhere, BOX).label == "unknown"


def test_what_is_seen_of_a_covered_container_is_outside() -> None:
    covered = replace(BOX, lid=Lid(OUTER, 0.075, None))
    assert membership(standing_at(1.0, 0.0), covered).label == "outside"
