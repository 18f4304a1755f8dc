"""`surefetch study commit` on scripted tables: what is written, and when nothing is."""

from pathlib import Path

import pytest
from recorded_table import numbers, record, save
from scripted_table import Table, thing

from surefetch.common.errors import BadInput
from surefetch.common.parameters import PROFILES, read_parameters, write_parameters
from surefetch.evaluation.fitting import commit_command

TABLE = Table((thing(0.9, -0.1), thing(0.9, 0.1, "other")))
ENOUGH = 120
"""Scenes without a wrong grasp that show a rate below 2 %."""


@pytest.fixture
def fitted(tmp_path: Path) -> Path:
    for profile in PROFILES:
        write_parameters(tmp_path / f"{profile}.json", numbers(profile))
    return tmp_path


def test_where_no_grasp_is_wrong_the_conformal_set_alone_decides(
    fitted: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(commit_command, "GRID", (0.5, 0.0))
    for seed in range(100_000, 100_000 + ENOUGH):
        save(fitted / "dev", *record(TABLE, wanted=0, seed=seed))
    assert commit_command.main([str(fitted / "dev"), "--parameters", str(fitted)]) == 0
    assert read_parameters(fitted / "extended.json").commit_at_least == 0.0


def test_too_few_scenes_prove_nothing_and_nothing_is_written(
    fitted: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = (fitted / "extended.json").read_bytes()
    save(fitted / "dev", *record(TABLE, wanted=0, seed=100_000))
    assert commit_command.main([str(fitted / "dev"), "--parameters", str(fitted)]) == 1
    assert (fitted / "extended.json").read_bytes() == before
    assert "nothing was written" in capsys.readouterr().out


def test_scenes_of_another_split_are_refused(fitted: Path) -> None:
    save(fitted / "cal", *record(TABLE, wanted=0, seed=200_000))
    with pytest.raises(BadInput, match="development scenes only"):
        commit_command.main([str(fitted / "cal"), "--parameters", str(fitted)])
