"""A few scenes are looked at twice, and what then differs is counted."""

import msgspec
import pytest
from recorded_table import record
from scripted_table import Reading, Table, thing

from surefetch.common.errors import InfrastructureError
from surefetch.evaluation.recordings import repeats
from surefetch.evaluation.recordings.recording import Repeated, Shot


def shots(*things: tuple[float, Reading]) -> tuple[Shot, ...]:
    """Of a table on which each thing stands at y and reads as told."""
    recording, _ = record(Table([thing(0.9, y, reads) for y, reads in things]), wanted=None)
    return recording.shots


def without_answers(shot: Shot) -> Shot:
    seen = shot.observations
    silent = tuple(msgspec.structs.replace(one, answers=None) for one in seen.detections)
    return msgspec.structs.replace(
        shot, observations=msgspec.structs.replace(seen, detections=silent)
    )


ONE = shots((-0.1, "match"), (0.1, "other"))


def test_two_scenes_of_a_hundred_are_looked_at_twice() -> None:
    n = sum(repeats.is_repeated("covered", seed) for seed in range(10_000))
    assert 160 < n < 240


def test_the_same_seen_again_does_not_differ() -> None:
    assert repeats.compared(ONE, ONE) == Repeated(candidates=6, differing=0)


def test_a_candidate_in_another_category_or_missing_differs() -> None:
    other = shots((-0.1, "match"), (0.1, "match"))
    assert repeats.compared(ONE, other) == Repeated(candidates=6, differing=3)
    assert repeats.compared(ONE, shots((-0.1, "match"))).differing == 3
    unanswered = [without_answers(shot) for shot in ONE]
    assert repeats.compared(ONE, unanswered).differing == 6


def test_recording_stops_when_more_than_one_of_two_hundred_differs() -> None:
    few = [Repeated(candidates=100, differing=0), Repeated(candidates=100, differing=1)]
    assert repeats.check(few) == Repeated(candidates=200, differing=1)
    assert repeats.check([]) == Repeated(candidates=0, differing=0)
    with pytest.raises(InfrastructureError, match="2 of 300 candidates"):
        repeats.check([*few, Repeated(candidates=100, differing=1)])
