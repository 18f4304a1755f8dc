"""What a person reads in the terminal while an episode runs."""

import io

import made_up_episode
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from rich.console import Console

from surefetch.common.messages import Perceived
from surefetch.evaluation.showing.progress import BAR_CELLS, Progress, bar


def shown(*, terminal: bool) -> str:
    page = io.StringIO()
    console = Console(file=page, force_terminal=terminal, width=100, highlight=False)
    progress = Progress(console)
    for event in made_up_episode.events():
        progress.show(event)
    progress.close()
    return page.getvalue()


@pytest.mark.parametrize(
    "words",
    [
        "understood  a red cylinder",
        "step 0  center  2 candidates, container open",
        "T1 outside",
        "0.950 ∈ Γ",
        "Γ = {T1 outside, not seen yet}",
        "→ right   Q: defer 0.700, right 0.100",
        "the red cylinder is the only one left",
        "T2 cannot be grasped: access: no room",
        "right done  (4.0 s of motion)",
        "grasped T1 (outside), delivered",
    ],
)
def test_everything_a_person_needs_is_said_without_a_terminal(words: str) -> None:
    assert words in shown(terminal=False)


def test_a_look_that_only_verifies_is_no_step() -> None:
    page = io.StringIO()
    progress = Progress(Console(file=page, width=100, highlight=False))
    events = made_up_episode.events()
    for event in events:
        progress.show(event)
    again = next(e for e in reversed(events) if isinstance(e.happening, Perceived))
    progress.show(again)
    assert page.getvalue().splitlines()[-1].startswith("    seen after it:  2 candidates")
    assert page.getvalue().count("step 1") == 1


def test_a_reason_that_was_given_is_not_given_again() -> None:
    page = io.StringIO()
    progress = Progress(Console(file=page, width=100, highlight=False))
    for event in made_up_episode.events()[:-1]:
        progress.show(event)
    said = page.getvalue()
    because = "the red cylinder is the only one left"
    progress.ended(replace(made_up_episode.ended(), outcome="deferred", because=because))
    assert because not in page.getvalue().removeprefix(said)


def test_long_sentences_go_on_below_their_beginning() -> None:
    page = io.StringIO()
    progress = Progress(Console(file=page, force_terminal=True, width=40, highlight=False))
    progress.ended(replace(made_up_episode.ended(), because="word " * 20))
    wrapped = [line for line in page.getvalue().splitlines() if "word" in line]
    assert len(wrapped) > 2
    assert all(line.startswith("  word") for line in wrapped)


def test_no_control_codes_reach_a_file() -> None:
    assert "\x1b" not in shown(terminal=False)


def test_a_terminal_is_left_with_its_cursor() -> None:
    page = shown(terminal=True)
    assert page.rfind("\x1b[?25h") > page.rfind("\x1b[?25l")


@given(st.floats(0.0, 1.0))
def test_a_bar_is_always_as_wide_as_its_column(share: float) -> None:
    assert len(bar(share)) == BAR_CELLS


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_the_larger_share_has_the_longer_bar(a: float, b: float) -> None:
    low, high = sorted((a, b))
    assert len(bar(low).strip()) <= len(bar(high).strip())
