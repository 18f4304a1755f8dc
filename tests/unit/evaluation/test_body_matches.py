"""The scorer's knowledge of which body has what."""

import pytest

from surefetch.common.cell import simulated_cell
from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.scenes.body_matches import body_matches
from surefetch.evaluation.scenes.candidate import Candidate, draw, plan_of
from surefetch.evaluation.scenes.table import NoRoom

CELL = simulated_cell()
SEED = 20


@pytest.fixture(params=FAMILIES)
def candidate(request: pytest.FixtureRequest) -> Candidate:
    """The first attempt that finds room for everything."""
    plan = plan_of(request.param, SEED)
    for attempt in range(20):
        try:
            return draw(plan, SEED, attempt, CELL)
        except NoRoom:
            continue
    raise AssertionError("no attempt found room")


def test_attributes_that_are_not_named_are_none(candidate: Candidate) -> None:
    asked = candidate.target
    for match in body_matches(candidate.scene, asked).values():
        assert (match.color is None) == (asked.color is None)
        assert (match.shape is None) == (asked.shape is None)
        assert (match.marking is None) == (asked.marking is None)
        assert match.relation is not None


def test_only_the_target_has_all_that_is_asked(candidate: Candidate) -> None:
    asked = candidate.target.relation
    fitting = [
        name
        for name, has in body_matches(candidate.scene, candidate.target).items()
        if False not in (has.color, has.shape, has.marking) and asked in ("any", has.relation)
    ]
    target = candidate.body("target")
    assert fitting == ([] if target is None else [target.name])
