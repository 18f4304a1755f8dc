"""After a removal that opened nothing, nobody is told that a look was taken after it."""

import io
from pathlib import Path

import made_up_episode
import pytest
from matplotlib.figure import Figure
from msgspec.structs import replace
from rich.console import Console

from surefetch.common.messages import Believed, Captured, Event
from surefetch.evaluation.running import ending
from surefetch.evaluation.showing import trace_figure
from surefetch.evaluation.showing.observed import Observed
from surefetch.evaluation.showing.progress import Progress


def failed_removal() -> tuple[Event, ...]:
    """The second look is expected after a removal, and seen to be an ordinary one."""
    return tuple(
        replace(event, happening=replace(event.happening, q="after_removal"))
        if isinstance(event.happening, Captured) and event.step == 1
        else event
        for event in made_up_episode.events()
    )


def without_last_belief() -> tuple[Event, ...]:
    """The belief never took the second look."""
    events = failed_removal()
    last = max(n for n, event in enumerate(events) if isinstance(event.happening, Believed))
    return events[:last]


BOTH = pytest.mark.parametrize(
    ("events", "q"), [(failed_removal(), "center"), (without_last_belief(), "after_removal")]
)


@BOTH
def test_the_terminal_shows_the_verified_condition(events: tuple[Event, ...], q: str) -> None:
    page = io.StringIO()
    progress = Progress(Console(file=page, width=100, highlight=False))
    for event in events:
        progress.show(event)
    progress.ended(made_up_episode.ended())
    (line,) = [line for line in page.getvalue().splitlines() if line.startswith("step 1")]
    assert line.startswith(f"step 1  {q}  2 candidates")


@BOTH
def test_the_records_of_an_episode_that_was_cut_short_have_it(
    events: tuple[Event, ...], q: str
) -> None:
    ended = ending.aborted("service_lost", "belief died", Observed(events, {}), None)
    assert [step.q for step in ended.steps] == ["center", q]


def test_the_trace_shows_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, _: drawn.append(figure))
    trace_figure.draw(Observed(failed_removal(), {}), tmp_path / "trace.png")
    titles = [axes.get_title(loc="left") for axes in drawn[0].axes]
    assert [title for title in titles if title] == ["(a)  center", "(b)  center"]
