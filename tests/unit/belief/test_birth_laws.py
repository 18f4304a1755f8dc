"""New tracks, and none, as evidence: laws whatever was counted."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from surefetch.belief.evidence import CategoryEvidence, Seen
from surefetch.belief.filter import FLOOR, Births, Memory, Model, Step, step
from surefetch.belief.first_belief import birth
from surefetch.common.emission import Emission
from surefetch.common.hypotheses import ABS, UNOBS
from surefetch.common.joint_belief import JointBelief
from surefetch.common.parameters import PRINTED, BirthCounts

times = st.integers(0, 50)
birth_counts = st.builds(
    BirthCounts,
    with_target=st.tuples(times, times),
    without=st.tuples(times, times, times),
    still_unseen=times,
)
probabilities = st.floats(1e-6, 1.0)
conditions = st.sampled_from(("center", "right", "high"))


@st.composite
def beliefs(draw: st.DrawFn) -> JointBelief:
    n = draw(st.integers(0, 3))
    masses = np.array([draw(probabilities) for _ in range(2 * n + 2)])
    masses /= masses.sum()
    tracks = tuple(range(1, n + 1))
    return JointBelief(tracks, masses[2:].reshape(n, 2), float(masses[0]), float(masses[1]))


def believing(births: Births | None) -> Model:
    table = {"right": {"target_inside": [5, 0, 0, 1, 2, 0, 0], "distractor": [1, 1, 0, 9, 1, 1, 0]}}
    return Model(CategoryEvidence(Emission(table)), PRINTED, births=births)


@settings(deadline=None)
@given(beliefs(), birth_counts)
def test_a_look_without_new_tracks_moves_unobs_alone_by_one_minus_the_chance_to_appear(
    belief: JointBelief, counts: BirthCounts
) -> None:
    after = birth(belief, belief.tracks, PRINTED, counts)
    assert sum(after.named().values()) == pytest.approx(1.0)
    odds = (after.p_unobs / after.p_abs) / (belief.p_unobs / belief.p_abs)
    assert odds == pytest.approx(1.0 - counts.p_appears)
    np.testing.assert_allclose(after.p_tracked / after.p_abs, belief.p_tracked / belief.p_abs)


@settings(deadline=None)
@given(beliefs(), birth_counts, st.integers(1, 4))
def test_new_tracks_share_alike_what_their_number_says_of_the_target(
    belief: JointBelief, counts: BirthCounts, n_new: int
) -> None:
    """Bayes over `abs`, `unobs and not among them`, `unobs and among them`, written out."""
    tracks = tuple(range(1, len(belief.tracks) + n_new + 1))
    after = birth(belief, tracks, PRINTED, counts)
    n, d = min(n_new, 2), counts.p_appears
    among = (counts.with_target[n - 1] + 1) / (sum(counts.with_target) + 2)
    clutter = (counts.without[n] + 1) / (sum(counts.without) + 3)
    born = after.p_tracked[len(belief.tracks) :].sum(axis=1)
    weights = [belief.p_abs * clutter, belief.p_unobs * (1 - d) * clutter]
    weights.append(belief.p_unobs * d * among)
    total = sum(weights) + belief.p_tracked.sum() * clutter
    found = [after.p_abs, after.p_unobs, born.sum()]
    assert found == pytest.approx([w / total for w in weights], rel=1e-9)
    np.testing.assert_allclose(born, born[0])


@settings(deadline=None)
@given(
    st.lists(st.tuples(conditions, st.booleans()), min_size=2, max_size=3, unique=True),
    st.dictionaries(st.tuples(conditions, st.booleans()), birth_counts),
)
def test_looks_that_show_nothing_new_commute(
    looks: list[tuple[str, bool]], table: dict[tuple[str, bool], BirthCounts]
) -> None:
    model = believing(lambda q, covered: table.get((q, covered)))
    first = step(Memory(), (1, 2), [Seen("a", 1, "UI")], "center", model)
    ends = []
    for order in permutations(range(len(looks))):
        done = first
        for nth in order:
            q, covered = looks[nth]
            seen = [Seen(f"{nth}", 1 + nth % 2, "MI")]
            done = step(done.memory, (1, 2), seen, q, model, covered=covered)
        ends.append([done.belief.p_unobs, done.belief.p_abs])
    np.testing.assert_allclose(ends, [ends[0]] * len(ends), rtol=1e-9)


def after_two(model: Model, *, counts_again: bool = True) -> Step:
    first = step(Memory(), (1,), [], "center", model)
    return step(first.memory, (1,), [], "right", model, look_counts=counts_again)


@settings(deadline=None)
@given(birth_counts)
def test_a_look_that_does_not_count_is_no_evidence_of_what_it_does_not_show(
    counts: BirthCounts,
) -> None:
    on, off = believing(lambda *_: counts), believing(None)
    again = after_two(on, counts_again=False).belief.named()
    assert again == after_two(off).belief.named()
    assert after_two(on).belief.p_unobs < again[UNOBS]


@settings(deadline=None)
@given(beliefs(), birth_counts)
def test_many_empty_looks_leave_absence_and_what_is_tracked(
    belief: JointBelief, counts: BirthCounts
) -> None:
    for _ in range(2000):
        belief = birth(belief, belief.tracks, PRINTED, counts)
        if belief.p_unobs < FLOOR:
            break
    named = belief.named()
    assert named[UNOBS] < 1e-9
    assert named[ABS] > 0.0


def test_the_cover_chooses_the_priors_of_the_first_look() -> None:
    mostly_absent = replace(PRINTED, absent=0.9, unobserved=0.05, tracked=0.05)
    model = Model(CategoryEvidence(Emission({})), mostly_absent, covered_priors=PRINTED)
    assert step(Memory(), (1,), [], "center", model).belief.p_abs == pytest.approx(0.9)
    under_lid = step(Memory(), (1,), [], "center", model, covered=True).belief
    assert under_lid.p_abs == pytest.approx(PRINTED.absent)
