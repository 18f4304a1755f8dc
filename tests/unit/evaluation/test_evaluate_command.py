"""`surefetch study evaluate`: what it prints, keeps, plays again and refuses."""

import json
import subprocess
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path

import msgspec
import pytest
from recorded_table import numbers, record, save
from replayed_table import TABLES

from surefetch.common.errors import BadInput
from surefetch.common.parameters import write_parameters
from surefetch.evaluation.replaying import command, manifest, results
from surefetch.evaluation.replaying.contenders import contender
from surefetch.evaluation.replaying.manifest import CODE
from surefetch.planner.profiles import PROFILES


def test_an_uncalibrated_belief_is_refused_with_the_command() -> None:
    full = {"full": numbers("extended").calibration()}
    parameters = {p: msgspec.structs.replace(numbers(p), calibrations=full) for p in PROFILES}
    with pytest.raises(BadInput, match="surefetch study calibrate"):
        contender("a1", "extended", parameters)


@pytest.mark.parametrize("label", ["ours@paper", "greedy@none", "nobody"])
def test_a_policy_with_a_profile_that_it_cannot_have_is_refused(label: str) -> None:
    with pytest.raises(BadInput):
        contender(label, "extended", {profile: numbers(profile) for profile in PROFILES})


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for profile in PROFILES:
        write_parameters(tmp_path / f"{profile}.json", numbers(profile))
    for n, table in enumerate(TABLES.values()):
        wanted = 0 if table.things else None
        recording, truth = record(table, wanted=wanted, seed=n)
        save(tmp_path / "recordings", recording, truth)
    return tmp_path


def test_the_command_prints_the_json_of_the_specification(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    assert command.main([*words, "--policies", "ours,always-defer", "--json"]) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert list(told) == ["policies"]
    assert list(told["policies"]) == ["ours", "always-defer"]
    row = told["policies"]["always-defer"]["families"]["partial"]
    assert set(row) == {"episodes", "successes", "wilson_95", "wrong_object", "false_defers"}
    assert (row["episodes"], row["successes"], row["false_defers"]) == (6, 1, 5)


def test_the_command_prints_tables_and_what_they_assume(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    assert command.main([*words, "--policies", "paper-method,a8,random,truth-oracle"]) == 0
    told = capsys.readouterr().out
    assert "paper-method" in told
    assert "realised cost" in told
    assert "assumed, not measured" in told


def test_what_was_played_is_not_played_again(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    words += ["--out", str(folder / "results"), "--json"]
    assert command.main([*words, "--policies", "ours"]) == 0
    first = (folder / "results/ours.jsonl").read_bytes()
    assert command.main([*words, "--policies", "greedy@paper,ours", "--jobs", "2"]) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert list(told["policies"]) == ["greedy@paper", "ours"]
    assert (folder / "results/ours.jsonl").read_bytes() == first
    found = manifest.read(folder / "results")
    assert found is not None and set(found.policies) == {"ours", "greedy@paper"}


def test_a_policy_that_changed_is_played_again(folder: Path) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    words += ["--out", str(folder / "results"), "--json", "--policies", "greedy"]
    assert command.main(words) == 0
    found = manifest.read(folder / "results")
    assert found is not None
    was = {"greedy": {**found.policies["greedy"], "code": "another"}}
    manifest.write(folder / "results", replace(found, policies=was))
    (folder / "results/greedy.jsonl").write_text("")
    assert command.main(words) == 0
    assert len(results.read(folder / "results", "greedy")) == len(TABLES)


def test_everything_that_a_replay_is_made_of_makes_a_policy_another() -> None:
    """But for how truth files are read."""
    program = "import sys, surefetch.evaluation.replaying.campaign; print(*sys.modules)"
    told = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, check=True, text=True, timeout=60
    )
    used = {name for name in told.stdout.split() if name.startswith("surefetch.")}
    left = {name for name in used if not f"{name}.".startswith(tuple(f"{c}." for c in CODE))}
    files = {name for name in left if not hasattr(import_module(name), "__path__")}
    assert files == {"surefetch.evaluation.scenes.truth"}


def test_results_of_other_outcomes_are_not_mixed(folder: Path) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    words += ["--out", str(folder / "results"), "--policies", "greedy", "--json"]
    assert command.main(words) == 0
    with pytest.raises(BadInput, match="other outcomes"):
        command.main([*words, "--outcome-seed", "1"])


def test_recordings_of_another_perception_are_refused(folder: Path) -> None:
    with pytest.raises(BadInput, match="Fit new ones"):
        command.main(["--recordings", str(folder / "recordings"), "--policies", "ours"])
