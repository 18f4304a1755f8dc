"""Words of the command line that cannot be used are refused before anything is started."""

from pathlib import Path

import pytest

from surefetch.common import policies
from surefetch.common.errors import BadInput
from surefetch.evaluation.running.request import read_request


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--scene", "hidden:1"], 'no family "hidden".\n  Families: visible, partial'),
        (["--scene", "covered"], "FAMILY:SEED"),
        (["--scene", "covered:-1"], "from 0 to 2\\^63 - 1"),
        (["--scene", "covered:9223372036854775808"], "whole number"),
        (["--scene", "covered:1.5"], "whole number"),
        (["--scene", "covered:²"], "whole number"),
        (["--scene", "covered:1", "--profile", "bold"], 'no profile "bold".\n  Profiles: paper'),
        (["--scene", "covered:1", "--policy", "a9"], 'no policy "a9".\n  Policies: ours'),
        (["--scene", "covered:1", "--policy", "ours", "--profile", "paper"], "its own profile"),
        (["  ", "--scene", "covered:1"], "instruction is empty"),
        (["red " * 200, "--scene", "covered:1"], "at most 500"),
        (["the red cylinder"], "name a scene"),
        (["--connect", "tcp/127.0.0.1:1"], "name a scene"),
        (["--scene", "covered:1", "--config", "nowhere.toml"], "nowhere.toml cannot be read"),
        (["--scene", "covered:1", "--inject", "lid@1"], "grasp@1, view@1, cover@1"),
        (["it", "--connect", "tcp/127.0.0.1:1", "--inject", "view@1"], "in simulation only"),
    ],
)
def test_what_cannot_be_used_is_refused_with_what_can(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match=said):
        read_request(words)
    assert list(tmp_path.iterdir()) == []


def test_a_configuration_that_lacks_a_key_is_refused_by_the_key(tmp_path: Path) -> None:
    config = tmp_path / "lab.toml"
    config.write_text('[endpoints]\nexecutor = "tcp/127.0.0.1:1"\n')
    with pytest.raises(BadInput, match=r"lab\.toml.*perception"):
        read_request(["--scene", "covered:1", "--config", str(config)])


def test_a_folder_with_other_files_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(BadInput, match="other files"):
        read_request(["--scene", "covered:1", "--out", str(tmp_path)])


def test_the_largest_seed_is_a_scene() -> None:
    request = read_request(["--scene", "absent:9223372036854775807"])
    assert str(request.scene) == "absent:9223372036854775807"


@pytest.mark.parametrize(
    ("profile", "policy", "expected"),
    [
        (None, None, ("extended", "ours")),
        ("paper", None, ("paper", "paper-method")),
        (None, "paper-method", ("paper", "paper-method")),
        ("extended", "ours", ("extended", "ours")),
    ],
)
def test_profile_and_policy_complete_each_other(
    profile: str | None, policy: str | None, expected: tuple[str, str]
) -> None:
    assert policies.choose(profile, policy) == expected


def test_injected_failures_are_told_with_the_scene() -> None:
    request = read_request(["--scene", "covered:1", "--inject", "view@1", "--inject", "grasp@0.5"])
    assert list(map(str, request.injected)) == ["view@1", "grasp@0.5"]
