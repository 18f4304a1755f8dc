"""Beliefs with one thing taken out, and a threshold for each."""

from functools import partial
from pathlib import Path

import msgspec
import pytest
from recorded_table import numbers, record, save
from scripted_table import CELL, Table, thing, thing_inside

from surefetch.belief.episode import EpisodeBelief
from surefetch.common.parameters import (
    FULL,
    PROFILES,
    Parameters,
    read_parameters,
    shipped_parameters,
    write_parameters,
)
from surefetch.evaluation.fitting import calibrate, calibrate_command
from surefetch.evaluation.fitting.sequences import beginnings, looks_along
from surefetch.evaluation.fitting.variants import (
    FACTORIZED,
    NO_MEMORY,
    POOLED_VIEWS,
    VARIANTS,
    believed,
    remembers,
    rules_for,
)
from surefetch.evaluation.recordings.recording import (
    Recording,
    RecordingTruth,
    exhaustive_path,
    paths,
)
from surefetch.evaluation.recordings.walk import Look

TABLE = Table(
    (thing(0.9, -0.1, center="unread", right="hidden"), thing(0.9, 0.1, "other", right="match"))
)
RIGHT_IS_UNSURE = {
    "target_inside": (2, 2, 2, 2, 2, 2, 2),
    "target_outside": (2, 2, 2, 2, 2, 2, 2),
    "distractor": (2, 2, 2, 2, 2, 2, 2),
}


def unlike_views() -> Parameters:
    plain = numbers("paper")
    return msgspec.structs.replace(plain, emissions=plain.emissions | {"right": RIGHT_IS_UNSURE})


def walked(variant: str, path: tuple[str, ...], parameters: Parameters) -> list[Look]:
    return along(*record(TABLE, wanted=0), path, parameters, variant)


def along(
    recording: Recording,
    truth: RecordingTruth,
    path: tuple[str, ...],
    parameters: Parameters,
    variant: str = FULL,
) -> list[Look]:
    begin = EpisodeBelief(rules_for(parameters, recording.target.relation, variant, 0.9))
    return looks_along(
        recording, truth, beginnings(path), CELL, begin, partial(believed, variant=variant),
        profile=parameters.profile, remembers=remembers(variant),
    )[path]  # fmt: skip


def beliefs(variant: str, path: tuple[str, ...], parameters: Parameters) -> list[dict[str, float]]:
    return [look.reply.belief for look in walked(variant, path, parameters)]


def test_without_memory_a_look_tells_the_same_whatever_came_before() -> None:
    after_two = beliefs(NO_MEMORY, ("right", "close_high"), numbers("paper"))[-1]
    at_once = beliefs(NO_MEMORY, ("close_high",), numbers("paper"))[-1]
    assert after_two == at_once
    assert beliefs(FULL, ("right", "close_high"), numbers("paper"))[-1] != at_once


def test_without_memory_a_track_is_gone_with_its_look() -> None:
    assert len(beliefs(NO_MEMORY, ("right",), numbers("paper"))[-1]) == 2 + 2
    assert len(beliefs(FULL, ("right",), numbers("paper"))[-1]) == 2 * 2 + 2


def test_pooled_views_count_an_answer_the_same_from_everywhere() -> None:
    views = ("right", "close_high")
    plain, unlike = numbers("paper"), unlike_views()
    assert beliefs(POOLED_VIEWS, views, unlike) != beliefs(FULL, views, unlike)
    assert beliefs(POOLED_VIEWS, (), plain)[0] == pytest.approx(
        beliefs(FULL, (), plain)[0], abs=0.02
    )


def test_a_factorized_belief_has_one_relation_for_all_tracks() -> None:
    belief = beliefs(FACTORIZED, ("right",), numbers("paper"))[-1]
    inside = [belief[f"{i}:inside"] / belief[f"{i}:outside"] for i in (1, 2)]
    assert inside[0] == pytest.approx(inside[1])


def test_every_variant_is_calibrated_on_its_own_belief(tmp_path: Path) -> None:
    write_parameters(tmp_path / "paper.json", unlike_views())
    for seed in range(200_000, 200_020):
        save(tmp_path / "cal", *record(TABLE, wanted=0, seed=seed))
    words = [str(tmp_path / "cal"), "--parameters", str(tmp_path), "--profile", "paper"]
    assert calibrate_command.main(words) == 0
    made = read_parameters(tmp_path / "paper.json").calibrations
    assert set(made) == set(VARIANTS)
    for variant in VARIANTS:
        path = exhaustive_path(False, CELL)
        looks = walked(variant, path, unlike_views())
        worst = max(1.0 - look.reply.belief[look.truth] for look in looks)
        assert made[variant].threshold == worst
    assert len({made[variant].threshold for variant in VARIANTS}) == len(VARIANTS)


def test_extended_is_calibrated_on_the_worst_look_of_any_sequence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(calibrate.EPISODES, "extended", 1)
    numbers_of = msgspec.structs.replace(unlike_views(), profile="extended")
    write_parameters(tmp_path / "extended.json", numbers_of)
    covered = Table((*TABLE.things, thing_inside()), covered=True)
    recording, truth = record(covered, wanted=2, seed=200_000)
    save(tmp_path / "cal", recording, truth)
    words = [str(tmp_path / "cal"), "--parameters", str(tmp_path), "--profile", "extended"]
    assert calibrate_command.main(words) == 0
    worst = {
        path: max(
            1.0 - look.reply.belief[look.truth]
            for look in along(recording, truth, path, numbers_of)
        )
        for path in paths(True, CELL, views_while_covered=True)
    }
    made = read_parameters(tmp_path / "extended.json").calibration()
    assert made.scores is not None
    assert made.scores.largest == max(worst.values())
    assert ("right_covered", "remove_cover", "right") in worst
    assert (
        "all sequences" in read_parameters(tmp_path / "extended.json").calibration().provenance.note
    )


@pytest.mark.parametrize("profile", PROFILES)
def test_what_ships_is_calibrated_for_every_variant(profile: str) -> None:
    shipped = shipped_parameters(profile)
    assert set(shipped.calibrations) == set(VARIANTS)
    full = shipped.calibration().provenance
    assert all(one.provenance == full for one in shipped.calibrations.values())
    assert full.note == calibrate_command.ALONG[profile]
