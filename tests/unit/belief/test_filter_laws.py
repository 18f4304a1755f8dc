"""Laws of the joint belief, whatever the numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.belief.evidence import CategoryEvidence, Seen
from surefetch.belief.filter import FLOOR, Memory, Model, Step, step
from surefetch.common.emission import Emission
from surefetch.common.hypotheses import CLASSES, OBSERVATIONS
from surefetch.common.parameters import PRINTED

CONDITIONS = ("center", "after_removal", "right")
counts_of_one = st.lists(st.integers(0, 40), min_size=7, max_size=7)
counts = st.dictionaries(
    st.sampled_from(CONDITIONS), st.dictionaries(st.sampled_from(CLASSES), counts_of_one)
)
conditions = st.sampled_from((*CONDITIONS, "never seen"))
labels = st.sampled_from((*OBSERVATIONS, None))
Look = tuple[str, int, list[tuple[int, str | None]]]


@st.composite
def episodes(draw: st.DrawFn) -> list[Look]:
    """Looks: condition, number of tracks by then, and (track, y) of each detection."""
    n_tracks, looks = 0, []
    for _ in range(draw(st.integers(1, 4))):
        n_tracks += draw(st.integers(0, 3))
        seen = draw(
            st.lists(st.tuples(st.integers(1, max(1, n_tracks)), labels), max_size=5)
            if n_tracks
            else st.just([])
        )
        looks.append((draw(conditions), n_tracks, seen))
    return looks


def fold(looks: list[Look], model: Model) -> list[Step]:
    memory, steps = Memory(), []
    for nth, (q, n_tracks, seen) in enumerate(looks):
        detections = [Seen(f"{nth}-{i}", track, y) for i, (track, y) in enumerate(seen)]
        steps.append(step(memory, range(1, n_tracks + 1), detections, q, model))
        memory = steps[-1].memory
    return steps


def model_of(table: dict[str, dict[str, list[int]]]) -> Model:
    return Model(CategoryEvidence(Emission(table)), PRINTED)


@settings(deadline=None)
@given(episodes(), counts)
def test_the_belief_stays_normalised(
    looks: list[Look], table: dict[str, dict[str, list[int]]]
) -> None:
    for done in fold(looks, model_of(table)):
        assert sum(done.belief.named().values()) == pytest.approx(1.0, abs=1e-12)
        assert min(done.belief.named().values()) >= 0.0


@settings(deadline=None)
@given(episodes(), counts, conditions)
def test_an_observation_with_a_known_id_changes_nothing(
    looks: list[Look], table: dict[str, dict[str, list[int]]], q: str
) -> None:
    model = model_of(table)
    done = fold(looks, model)[-1]
    tracks = done.belief.tracks
    again = [Seen(id_, track, "MI") for id_ in done.memory.counted_ids for track in tracks[:1]]
    repeated = step(done.memory, tracks, again, q, model)
    assert repeated.counted == (False,) * len(again)
    assert repeated.memory.n_observations == done.memory.n_observations
    np.testing.assert_allclose(
        list(repeated.belief.named().values()), list(done.belief.named().values()), rtol=1e-12
    )


@settings(deadline=None)
@given(episodes(), counts, st.integers(1, 50))
def test_renumbering_tracks_renumbers_the_belief(
    looks: list[Look], table: dict[str, dict[str, list[int]]], shift: int
) -> None:
    model = model_of(table)
    plain = fold(looks, model)[-1]
    memory = Memory()
    for nth, (q, n_tracks, seen) in enumerate(looks):
        detections = [Seen(f"{nth}-{i}", shift + track, y) for i, (track, y) in enumerate(seen)]
        done = step(memory, range(shift + 1, shift + n_tracks + 1), detections, q, model)
        memory = done.memory
    assert done.belief.tracks == tuple(shift + i for i in plain.belief.tracks)
    assert np.array_equal(done.belief.p_tracked, plain.belief.p_tracked)
    assert done.belief.p_unobs == plain.belief.p_unobs


@settings(deadline=None)
@given(episodes(), counts)
def test_no_answer_tells_absent_from_not_seen(
    looks: list[Look], table: dict[str, dict[str, list[int]]]
) -> None:
    for done in fold(looks, model_of(table)):
        if min(done.prior.p_unobs, done.prior.p_abs) > FLOOR:
            before = done.prior.p_abs / done.prior.p_unobs
            assert done.belief.p_abs / done.belief.p_unobs == pytest.approx(before, rel=1e-9)


@settings(deadline=None)
@given(episodes(), counts)
def test_birth_takes_from_what_was_not_seen_and_from_nothing_else(
    looks: list[Look], table: dict[str, dict[str, list[int]]]
) -> None:
    steps = fold(looks, model_of(table))
    for before, after in zip(steps, steps[1:], strict=False):
        old, prior = before.belief.named(), after.prior.named()
        assert all(prior[z] == p for z, p in old.items() if z != "unobs")
        born = sum(p for z, p in prior.items() if z not in old)
        assert prior["unobs"] + born == pytest.approx(old["unobs"], rel=1e-12)
