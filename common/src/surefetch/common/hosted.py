"""What a service is to the runner: which method answers which topic, and what else it may have.

A service knows no bus, no thread and no signal. Its `handles` are run one after another by the work
loop, in the process's main thread. What must be answered while the work loop is busy (a frame, a
stop, an instruction) says `concurrent=True` and gets a thread of its topic's own; such a method
must not touch what the work loop changes.

A method that starts something long returns `Later(reply, job)`: the reply leaves at once, and the
job runs in the work loop. So the planner::

    class PlannerService:
        name, backend = PLANNER, "expectimax"

        @property
        def handles(self) -> tuple[Handle[Any, Any], ...]:
            return (
                Handle(INSTRUCT, self.instruct, concurrent=True),
                Handle(CANCEL, self.cancel, concurrent=True),
            )

        def instruct(self, request: Instruct) -> Later[Accepted]:
            if not self._free.acquire(blocking=False):
                raise Refused("BUSY", "an episode is running; cancel it first")
            accepted = self._understand(request)
            return Later(accepted, lambda: self._run_episode(accepted))

A method refuses by raising a `SurefetchError`, which the asker meets again. Any other exception
ends the process with status 70: a service whose state is in doubt must not serve on.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Generic, Protocol, TypeVar, runtime_checkable

from surefetch.common.messages import Message
from surefetch.common.topics import Topic

IDLE: Final = "idle"
"""What a service that does nothing says of its doing."""

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)


@dataclass(frozen=True)
class Later(Generic[R]):
    """A reply that leaves now, and work that the work loop does after it."""

    reply: R
    job: Callable[[], None]


@dataclass(frozen=True)
class Handle(Generic[Q, R]):
    """Which method answers a topic."""

    topic: Topic[Q, R]
    answer: Callable[[Q], R | Later[R]]
    concurrent: bool = False
    """Answered by the topic's own thread, also while the work loop is busy."""


class Service(Protocol):
    """What the runner hosts."""

    @property
    def name(self) -> str: ...

    @property
    def backend(self) -> str:
        """Which implementation runs: `pybullet`, `classical` and so on."""
        ...

    @property
    def doing(self) -> str:
        """In a few words, for `surefetch status`; read from another thread."""
        ...

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        """Every topic it answers, status and journal aside."""
        ...


@runtime_checkable
class MissesPeers(Protocol):
    """A service that wants to know when another one dies."""

    def peer_gone(self, service: str) -> None:
        """Called from a thread of the bus; must return at once."""
        ...


@runtime_checkable
class Ends(Protocol):
    """A service that has something to bring to rest."""

    def end(self) -> None:
        """The process was told to end: make the work under way come to its end soon.

        Called once, from another thread than the work loop's; the work loop has 3 s from then on.
        """
        ...


@runtime_checkable
class Closes(Protocol):
    """A service that holds something to give back."""

    def close(self) -> None:
        """Called last, in the work loop's thread."""
        ...
