"""Words lead to functions; errors become a sentence and an exit code."""

import subprocess
import sys

import pytest

from surefetch.common.cli import COMMANDS, Command, main


@pytest.fixture(autouse=True)
def made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    for word, function in (
        ("end", "made_up_commands:main"),
        ("elsewhere", "surefetch.nowhere.run:main"),
        ("heavy", "made_up_heavy:main"),
    ):
        monkeypatch.setitem(COMMANDS, word, Command(function, "", ""))


@pytest.mark.parametrize(
    ("how", "status", "said"),
    [
        ("well", 0, ""),
        ("bad-input", 2, "surefetch: the word blorp is not understood\n"),
        ("infrastructure", 3, "surefetch: belief is not there\n"),
        ("refused", 1, "surefetch: the lift failed\n"),
        ("interrupted", 130, "surefetch: interrupted from the keyboard.\n"),
    ],
)
def test_every_end_has_its_exit_code_and_at_most_a_sentence(
    how: str, status: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["end", how]) == status
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("", said)


def test_with_debug_the_place_in_the_code_is_told_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--debug", "end", "bad-input"]) == 2
    said = capsys.readouterr().err
    assert "made_up_commands.py" in said
    assert said.endswith("surefetch: the word blorp is not understood\n")


def test_an_error_of_our_own_is_told_in_full(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["end", "bug"]) == 3
    said = capsys.readouterr().err
    assert "ZeroDivisionError: nothing to divide by" in said
    assert said.endswith("please report it.\n")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["rum"], 'there is no command "rum". Did you mean "run"?'),
        (["serve", "belif"], 'there is no service "belif". Did you mean "belief"?'),
        (["elsewhere"], "elsewhere needs the package surefetch-nowhere, which is not installed"),
        (["heavy"], "heavy needs the Python package a_drivers_package, which is not installed"),
    ],
)
def test_what_is_not_there_is_named(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    assert f"surefetch: {said}" in capsys.readouterr().err


@pytest.mark.parametrize("words", [[], ["--help"], ["-h"], ["help"]])
def test_the_help_has_a_line_and_an_example_for_every_command(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 0
    said = capsys.readouterr().out
    for word, command in COMMANDS.items():
        assert f"  {word:<9} {command.does}\n" in said
        assert f"$ {command.example}\n" in said


@pytest.mark.parametrize("words", [["serve"], ["serve", "--help"]])
def test_serve_tells_what_can_be_served(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 0
    assert "surefetch serve {executor,perception,belief,planner}" in capsys.readouterr().out


def test_the_version_is_that_of_the_distribution(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == "surefetch 0.1.0\n"


def test_a_reader_that_has_seen_enough_is_no_error() -> None:
    program = "import sys; from surefetch.common.cli import main; sys.exit(main(['--help']))"
    writer = subprocess.Popen(
        [sys.executable, "-c", f"import time; time.sleep(0.3); {program}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert writer.stdout is not None
    assert writer.stderr is not None
    writer.stdout.close()
    assert writer.stderr.read() == b""
    writer.stderr.close()
    assert writer.wait() == 141
