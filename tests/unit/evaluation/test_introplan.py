"""IntroPlan keeps a conformal set of options, and learned only what was right in hindsight."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from recorded_table import numbers, record, save
from scripted_table import CELL, Table, thing, thing_inside

from surefetch.common.errors import BadInput
from surefetch.common.messages import Defer, Grasp
from surefetch.common.parameters import PROFILES, Provenance, write_parameters
from surefetch.evaluation.policies import introplan_knowledge
from surefetch.evaluation.policies.introplan import IntroPlan, best_of, the_only_one
from surefetch.evaluation.policies.introplan_chances import CHANCES, LITE, STRONG, likely
from surefetch.evaluation.policies.introplan_knowledge import FOLDS, NO_FOLD, Forests, Knowledge
from surefetch.evaluation.policies.introplan_situation import (
    GRASP_FIRST,
    LOOK,
    NOT_LISTED,
    OPEN,
    OPTIONS,
    choices,
    feature_names,
)
from surefetch.evaluation.recordings.recording import Path as Looks
from surefetch.evaluation.replaying.contenders import contender
from surefetch.evaluation.replaying.scene import ready
from surefetch.evaluation.tuning import introplan_command
from surefetch.evaluation.tuning.introplan_fit import Table as Lessons
from surefetch.evaluation.tuning.introplan_fit import fit_forests
from surefetch.evaluation.tuning.introplan_lessons import Lesson, lessons_of

UNREAD_FIRST = Table((thing(0.9, -0.1, "other", center="unread"), thing(0.9, 0.1, center="unread")))
CLEAR = Table((thing(0.9, -0.1), thing(0.9, 0.1, "other")))
COVERED = Table((thing_inside(), thing(0.8, 0.2, "other")), covered=True)
ABSENT = Table((thing(0.9, -0.1, "other"), thing(0.9, 0.1, "other")))
ONE = contender("always-defer", "extended", {profile: numbers(profile) for profile in PROFILES})


def lessons(table: Table, wanted: int | None) -> dict[Looks, Lesson]:
    scene = ready(*record(table, wanted=wanted))
    return {lesson.met.path: lesson for lesson in lessons_of(scene, ONE, CELL)}


def right(lesson: Lesson) -> set[int]:
    return set(np.flatnonzero(lesson.right).tolist())


def test_nothing_but_the_grasp_is_right_where_the_target_is_clear() -> None:
    assert {frozenset(right(lesson)) for lesson in lessons(CLEAR, 0).values()} == {
        frozenset({GRASP_FIRST})
    }


def test_looking_is_right_where_it_leads_to_the_target_and_a_grasp_would_not() -> None:
    found = lessons(UNREAD_FIRST, 1)
    assert LOOK in right(found[()])
    assert GRASP_FIRST not in right(found[()])
    assert right(found[("right",)]) == {GRASP_FIRST}


def test_opening_is_right_where_the_target_is_under_the_cover_alone() -> None:
    found = lessons(COVERED, 0)
    assert OPEN in right(found[()])
    assert right(found[("remove_cover",)]) == {GRASP_FIRST}
    assert OPEN not in right(lessons(COVERED, 1)[()])


def test_where_the_target_is_absent_no_option_that_is_listed_is_right() -> None:
    for table in (ABSENT, CLEAR, COVERED):
        assert {frozenset(right(one)) for one in lessons(table, None).values()} == {
            frozenset({NOT_LISTED})
        }


def test_all_situations_have_something_that_is_right_and_open() -> None:
    for table in (CLEAR, UNREAD_FIRST, COVERED, ABSENT):
        for wanted in (None, 0, 1):
            for lesson in lessons(table, wanted).values():
                is_open = [choice is not None for choice in choices(lesson.met.now)]
                assert lesson.right.any()
                assert not (lesson.right & ~np.array(is_open)).any()


def made_up(right_options: np.ndarray, fold: np.ndarray) -> Knowledge:
    """Knowledge of random situations, with a model of no depth of insight."""
    rng = np.random.default_rng(0)
    rounds, inner = 2, 2**introplan_knowledge.DEPTH - 1
    shape = (FOLDS, rounds, len(OPTIONS))
    n_features = len(feature_names(CELL))
    origin = introplan_knowledge.Origin(
        profile="extended", parameters="-", features=feature_names(CELL), lessons=NOWHERE,
        calibration=NOWHERE, command="-",
    )  # fmt: skip
    return Knowledge(
        origin,
        rng.integers(0, 2, (len(fold), n_features)).astype(float),
        right_options,
        fold.astype(np.uint8),
        Forests(
            rng.integers(0, n_features, (*shape, inner)).astype(np.uint8),
            rng.random((*shape, inner), np.float32),
            rng.random((*shape, inner + 1), np.float32),
            1.5,
        ),
        {name: rng.random((NO_FOLD + 1, 30)) for name in CHANCES},
    )


NOWHERE = Provenance(cell="-", backend="-", split="none", n_episodes=0, seeds="", note="-")
KNOWN = made_up(np.random.default_rng(1).random((40, len(OPTIONS))) < 0.3, np.arange(40) % FOLDS)


@pytest.mark.parametrize("name", CHANCES)
@pytest.mark.parametrize("held_out", [0, NO_FOLD])
def test_chances_are_shared_by_what_is_open_alone(name: str, held_out: int) -> None:
    for table in (CLEAR, COVERED, ABSENT):
        for lesson in lessons(table, None).values():
            p = CHANCES[name](lesson.met.now, lesson.met.view, KNOWN, held_out)
            is_open = np.array([choice is not None for choice in choices(lesson.met.now)])
            assert p.sum() == pytest.approx(1.0)
            assert (p[~is_open] == 0.0).all()
            assert (p[is_open] > 0.0).all()


@settings(deadline=None)
@given(st.lists(st.floats(0.0, 1.0), min_size=5, max_size=5), st.floats(0, 1), st.floats(0, 1))
def test_a_higher_threshold_keeps_what_a_lower_one_kept(p: list[float], a: float, b: float) -> None:
    low, high = sorted((a, b))
    assert set(likely(np.array(p), low)) <= set(likely(np.array(p), high))


@given(st.sets(st.integers(0, 4)))
def test_the_lite_variant_asks_for_help_unless_one_option_is_left(kept: set[int]) -> None:
    assert the_only_one(kept) == (kept.copy().pop() if len(kept) == 1 else NOT_LISTED)


@given(st.sets(st.integers(0, 4)), st.booleans())
def test_the_strong_variant_looks_while_a_look_is_likely(kept: set[int], heeds: bool) -> None:
    chosen = best_of(kept, heeds_not_listed=heeds)
    assert chosen in kept | {NOT_LISTED}
    if kept & {LOOK, OPEN}:
        assert chosen == min(kept & {LOOK, OPEN})
    elif chosen != NOT_LISTED:
        assert kept - {NOT_LISTED} == {chosen}
        assert not (heeds and NOT_LISTED in kept)


def test_nothing_is_learned_from_the_fold_that_is_held_out() -> None:
    """Only situations of one fold say that looking is right."""
    fold = np.arange(40) % FOLDS
    said = np.zeros((40, len(OPTIONS)), bool)
    said[:, GRASP_FIRST] = fold != 2
    said[:, LOOK] = fold == 2
    known = made_up(said, fold)
    for situation in known.situations:
        assert known.votes(situation, 3, held_out=2)[LOOK] == 0.0
    in_fold = known.situations[fold == 2]
    assert any(known.votes(situation, 3, NO_FOLD)[LOOK] > 0.0 for situation in in_fold)


def test_knowledge_is_read_as_it_was_written(tmp_path: Path) -> None:
    path = introplan_knowledge.write(tmp_path, KNOWN)
    read = introplan_knowledge.parse(path.read_bytes(), path.name)
    assert read.origin == KNOWN.origin
    for situation in KNOWN.situations:
        assert (read.votes(situation, 3, 1) == KNOWN.votes(situation, 3, 1)).all()
        assert (read.forests.p(situation, 4) == KNOWN.forests.p(situation, 4)).all()
    for name in CHANCES:
        assert read.q_hat(name, 0.85, NO_FOLD) == KNOWN.q_hat(name, 0.85, NO_FOLD)


def test_damaged_knowledge_is_refused_by_name() -> None:
    with pytest.raises(BadInput, match="here is damaged"):
        introplan_knowledge.parse(b"PK nothing", "here")


def test_a_forest_of_arrays_says_what_the_fitted_one_says(monkeypatch: pytest.MonkeyPatch) -> None:
    ensemble = pytest.importorskip("sklearn.ensemble")
    fitted = []

    class Kept(ensemble.GradientBoostingClassifier):  # type: ignore[misc, name-defined]
        def fit(self, *args: object, **kwargs: object) -> object:
            fitted.append(self)
            return super().fit(*args, **kwargs)

    monkeypatch.setattr(ensemble, "GradientBoostingClassifier", Kept)
    rng = np.random.default_rng(0)
    situations = rng.random((200, 6)).astype(np.float32).astype(np.float64)
    options = np.where(situations[:, 0] > 0.5, 0, np.where(situations[:, 1] > 0.5, 2, 4))
    table = Lessons(
        situations, np.eye(len(OPTIONS), dtype=bool)[options], (np.arange(200) % FOLDS).astype("u1")
    )
    forests = replace(fit_forests(table), temperature=1.0)
    for fold, forest in enumerate(fitted):
        ours = np.array([forests.p(one, fold) for one in situations])
        theirs = forest.predict_proba(situations)
        assert ours[:, [0, 2, 4]] == pytest.approx(theirs, abs=1e-5)
        assert (ours[:, [1, 3]] < 1e-5).all()


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for profile in PROFILES:
        write_parameters(tmp_path / f"{profile}.json", numbers(profile))
    for split, first in (("development", 100_000), ("calibration", 200_000)):
        tables = ((CLEAR, 0), (UNREAD_FIRST, 1), (COVERED, 0), (ABSENT, None))
        for n in range(20):
            table, wanted = tables[n % len(tables)]
            recording, truth = record(table, wanted=wanted, seed=first + n)
            save(tmp_path / split, recording, truth)
    return tmp_path


def fit(folder: Path, development: str, calibration: str) -> Callable[[], int]:
    words = [str(folder / development), "--calibration", str(folder / calibration)]
    words += ["--parameters", str(folder), "--profile", "extended", "--out", str(folder / "out")]
    return lambda: introplan_command.main(words)


def test_what_was_learned_on_scripted_tables_fetches_from_them(folder: Path) -> None:
    pytest.importorskip("sklearn")
    assert fit(folder, "development", "calibration")() == 0
    path = folder / "out" / introplan_knowledge.name_of("extended")
    known = introplan_knowledge.parse(path.read_bytes(), path.name)
    assert known.origin.lessons.split == "development"
    assert known.origin.calibration.split == "calibration"
    for variant in (STRONG, LITE):
        policy = IntroPlan(variant, known=known)
        chosen = policy.act(lessons(CLEAR, 0)[()].met.now)
        assert isinstance(chosen, Grasp)
        assert "grasp the first" in policy.because
        assert IntroPlan(variant, known=known).act(lessons(ABSENT, 0)[()].met.now) == Defer()


@pytest.mark.parametrize("split", [("calibration", "calibration"), ("development", "development")])
def test_scenes_of_another_split_are_not_learned_from(folder: Path, split: tuple[str, str]) -> None:
    with pytest.raises(BadInput, match=r"uses (development|calibration) scenes only"):
        fit(folder, *split)()


@pytest.mark.parametrize("profile", PROFILES)
def test_what_ships_is_small_and_describes_situations_as_the_policy_does(profile: str) -> None:
    known = introplan_knowledge.shipped(profile)
    assert known.origin.profile == profile
    assert known.origin.features == feature_names(CELL)
    assert known.situations.shape[1] == len(known.origin.features)
    assert known.origin.lessons.split == "development"
    assert known.origin.calibration.split == "calibration"
    folder = Path(introplan_knowledge.__file__).parent / "tuned"
    assert (folder / introplan_knowledge.name_of(profile)).stat().st_size < 1_000_000
