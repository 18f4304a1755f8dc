"""One episode as an observer on the bus saw it: the value behind every picture of a run. Pure."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from surefetch.common.messages import (
    Accepted,
    Acted,
    Acting,
    Believed,
    Captured,
    Decided,
    Ended,
    Event,
    Frame,
    FrameId,
    Motion,
    Observations,
    Perceived,
)

Seen = Event | Observations | Motion


@dataclass(frozen=True, eq=False)
class Observed:
    """Everything seen, in order of arrival, and the frames that were fetched."""

    log: tuple[Seen, ...]
    frames: Mapping[FrameId, Frame]

    @property
    def events(self) -> tuple[Event, ...]:
        """The planner's events, in order."""
        return tuple(seen for seen in self.log if isinstance(seen, Event))

    @property
    def observations(self) -> dict[FrameId, Observations]:
        """What perception said of each frame."""
        return {seen.frame: seen for seen in self.log if isinstance(seen, Observations)}

    @property
    def accepted(self) -> Accepted | None:
        """How the episode began, if it did."""
        return next((e.happening for e in self.events if isinstance(e.happening, Accepted)), None)

    @property
    def ended(self) -> Ended | None:
        """How the episode ended, if it did."""
        return next((e.happening for e in self.events if isinstance(e.happening, Ended)), None)


@dataclass(frozen=True, eq=False)
class Step:
    """One look and what followed from it; what did not happen is None."""

    number: int
    captured: Captured
    perceived: Perceived | None = None
    believed: Believed | None = None
    decided: Decided | None = None
    acting: tuple[Acting, ...] = ()
    acted: tuple[Acted, ...] = ()

    @property
    def q(self) -> str:
        """The viewing condition: as verified, or as expected where no belief took the look."""
        return self.captured.q if self.believed is None else self.believed.q


def steps(events: tuple[Event, ...]) -> Iterator[Step]:
    """The looks of an episode, in order."""
    step: Step | None = None
    for event in events:
        happening = event.happening
        if isinstance(happening, Captured):
            if step is not None:
                yield step
            step = Step(event.step, happening)
        elif step is not None:
            step = _with(step, event)
    if step is not None:
        yield step


def _with(step: Step, event: Event) -> Step:
    happening = event.happening
    if isinstance(happening, Perceived):
        return replace(step, perceived=happening)
    if isinstance(happening, Believed):
        return replace(step, believed=happening)
    if isinstance(happening, Decided):
        return replace(step, decided=happening)
    if isinstance(happening, Acting):
        return replace(step, acting=(*step.acting, happening))
    if isinstance(happening, Acted):
        return replace(step, acted=(*step.acted, happening))
    return step
