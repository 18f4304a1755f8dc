"""The one table of topics: who may say what to whom. Code, tests, README read it."""

from dataclasses import dataclass
from enum import Enum
from typing import Any, Final, Generic, Literal, TypeVar

from surefetch.common import messages as m

EXECUTOR: Final = "executor"
PERCEPTION: Final = "perception"
BELIEF: Final = "belief"
PLANNER: Final = "planner"
SERVICES: Final = (EXECUTOR, PERCEPTION, BELIEF, PLANNER)

Role = Literal["executor", "perception", "belief", "planner", "operator", "scorer"]
"""Operator: the command line and any client. Scorer: `run` and `study` on a simulated cell, which
may load scenes and ask for the truth."""


class Traffic(Enum):
    """How a message travels; `zenoh_bus` maps it to priority, express and congestion control."""

    STOP = "stop"
    COMMAND = "command"
    DECISION = "decision"
    BULK = "bulk"
    EVENT = "event"


Q = TypeVar("Q", bound=m.Message)
R = TypeVar("R", bound=m.Message)


@dataclass(frozen=True)
class Topic(Generic[Q, R]):
    """A question that one service answers.

    The key is ``cell/<cell>/<service>/<boot>/<verb>``; `stop` has no boot, so that every executor
    that hears it stops.
    """

    service: str
    verb: str
    request: type[Q]
    reply: type[R]
    traffic: Traffic
    senders: tuple[Role, ...]
    max_request_bytes: int = 64 * 1024
    max_reply_bytes: int = 64 * 1024
    simulated_only: bool = False

    @property
    def name(self) -> str:
        """As in sentences and journals: ``executor/capture``."""
        return f"{self.service}/{self.verb}"


@dataclass(frozen=True)
class Stream(Generic[Q]):
    """Messages that one service publishes for whoever listens; the protocol needs none."""

    service: str
    verb: str
    message: type[Q]
    listeners: tuple[Role, ...]
    max_bytes: int = 4 * 1024 * 1024
    journaled: bool = True
    """False where the service's journal holds the same in a reply."""

    @property
    def name(self) -> str:
        """As in sentences and journals: ``planner/event``."""
        return f"{self.service}/{self.verb}"


MiB = 1024 * 1024

CAPTURE = Topic(EXECUTOR, "capture", m.Capture, m.FrameInfo, Traffic.COMMAND, ("planner",))
FRAME = Topic(
    EXECUTOR,
    "frame",
    m.FrameId,
    m.Frame,
    Traffic.BULK,
    ("perception", "operator", "scorer"),
    max_reply_bytes=64 * MiB,
)
OBSERVE = Topic(
    PERCEPTION,
    "observe",
    m.Observe,
    m.Observations,
    Traffic.DECISION,
    ("planner",),
    max_reply_bytes=16 * MiB,
)
VOCABULARY = Topic(
    PERCEPTION, "vocabulary", m.Empty, m.Vocabulary, Traffic.DECISION, ("planner", "operator")
)
UPDATE = Topic(
    BELIEF,
    "update",
    m.Update,
    m.BeliefReply,
    Traffic.DECISION,
    ("planner",),
    max_request_bytes=16 * MiB,
    max_reply_bytes=16 * MiB,
)
FEASIBLE = Topic(
    EXECUTOR,
    "feasible",
    m.AskFeasible,
    m.Feasibility,
    Traffic.DECISION,
    ("planner",),
    max_request_bytes=16 * MiB,
    max_reply_bytes=MiB,
)
EXECUTE = Topic(
    EXECUTOR,
    "execute",
    m.Command,
    m.Outcome,
    Traffic.COMMAND,
    ("planner",),
    max_request_bytes=16 * MiB,
    max_reply_bytes=16 * MiB,
)
INSTRUCT = Topic(PLANNER, "instruct", m.Instruct, m.Accepted, Traffic.COMMAND, ("operator",))
CANCEL = Topic(PLANNER, "cancel", m.Cancel, m.Empty, Traffic.COMMAND, ("operator",))
STOP = Topic(EXECUTOR, "stop", m.Stop, m.Stopped, Traffic.STOP, ("operator", "planner"))
LOAD_SCENE = Topic(
    EXECUTOR,
    "scene",
    m.Scene,
    m.SceneLoaded,
    Traffic.COMMAND,
    ("scorer",),
    max_request_bytes=MiB,
    simulated_only=True,
)
TRUTH = Topic(
    EXECUTOR,
    "truth",
    m.AskTruth,
    m.Truth,
    Traffic.COMMAND,
    ("scorer",),
    max_reply_bytes=16 * MiB,
    simulated_only=True,
)

STATUS = {
    service: Topic(service, "status", m.Empty, m.Status, Traffic.COMMAND, ("operator", "scorer"))
    for service in SERVICES
}
JOURNAL = {
    service: Topic(
        service,
        "journal",
        m.JournalPage,
        m.JournalBytes,
        Traffic.BULK,
        ("operator", "scorer"),
        max_reply_bytes=16 * MiB,
    )
    for service in SERVICES
}

TOPICS: Final[tuple[Topic[Any, Any], ...]] = (
    CAPTURE,
    FRAME,
    OBSERVE,
    VOCABULARY,
    UPDATE,
    FEASIBLE,
    EXECUTE,
    INSTRUCT,
    CANCEL,
    STOP,
    LOAD_SCENE,
    TRUTH,
    *STATUS.values(),
    *JOURNAL.values(),
)

EVENTS = Stream(PLANNER, "event", m.Event, ("operator", "scorer"))
OBSERVED = Stream(PERCEPTION, "observed", m.Observations, ("operator", "scorer"), 16 * MiB, False)
MOVED = Stream(EXECUTOR, "moved", m.Motion, ("operator", "scorer"), journaled=False)

STREAMS: Final[tuple[Stream[Any], ...]] = (EVENTS, OBSERVED, MOVED)
