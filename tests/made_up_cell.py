"""A cell in one process: stand-ins for the four services, which tell the made-up episode."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import made_up_episode
from msgspec.structs import replace

from surefetch.common.bus import Bus
from surefetch.common.errors import Refused
from surefetch.common.journal import JournalWriter
from surefetch.common.local_bus import LocalBus, LocalCell
from surefetch.common.messages import (
    Accepted,
    Acted,
    AskTruth,
    Cancel,
    Empty,
    Event,
    Frame,
    FrameId,
    Instruct,
    Perceived,
    Scene,
    SceneLoaded,
    Stop,
    Stopped,
    Truth,
)
from surefetch.common.runner import Handle, Host, JournaledBus, Later
from surefetch.common.topics import (
    BELIEF,
    CANCEL,
    EVENTS,
    EXECUTOR,
    FRAME,
    INSTRUCT,
    LOAD_SCENE,
    MOVED,
    OBSERVED,
    PERCEPTION,
    PLANNER,
    STOP,
    TRUTH,
)

backend = "made-up"


class Idle:
    """A service that answers nothing of its own."""

    backend = backend
    doing = "idle"
    handles: tuple[Handle[Any, Any], ...] = ()

    def __init__(self, name: str) -> None:
        self.name = name


class MadeUpExecutor(Idle):
    """Has the frames, counts the stops."""

    def __init__(self, touched: tuple[str, ...]) -> None:
        super().__init__(EXECUTOR)
        self._touched = touched
        self.stops = 0
        self.handles = (
            Handle(FRAME, self.frame, concurrent=True),
            Handle(STOP, self.stop, concurrent=True),
            Handle(LOAD_SCENE, self.load),
            Handle(TRUTH, self.truth),
        )

    def frame(self, wanted: FrameId) -> Frame:
        return made_up_episode.frame(wanted.counter)

    def stop(self, stop: Stop) -> Stopped:
        self.stops += 1
        return Stopped(was_moving=True, took_s=0.0)

    def load(self, scene: Scene) -> SceneLoaded:
        return SceneLoaded(bodies=len(scene.bodies), largest_shift_m=0.0)

    def truth(self, ask: AskTruth) -> Truth:
        return Truth(
            bodies=(),
            lid_position_world_m=None,
            touched=self._touched,
            held=None,
            segmentation=None,
        )


class MadeUpPlanner(Idle):
    """Tells the made-up episode, event by event; `pause` is called before each."""

    def __init__(self, bus: Bus, pause: Callable[[Event], None]) -> None:
        super().__init__(PLANNER)
        self._bus = bus
        self._pause = pause
        self.cancelled = threading.Event()
        self.handles = (
            Handle(INSTRUCT, self.instruct, concurrent=True),
            Handle(CANCEL, self.cancel, concurrent=True),
        )

    def instruct(self, instruct: Instruct) -> Later[Accepted]:
        if "unicorn" in instruct.sentence:
            raise Refused("BAD_INPUT", '"unicorn" is nothing that this perception can tell.', 2)
        first = made_up_episode.events()[0].happening
        assert isinstance(first, Accepted)
        return Later(first, self._tell)

    def cancel(self, cancel: Cancel) -> Empty:
        self.cancelled.set()
        return Empty()

    def _tell(self) -> None:
        for event in made_up_episode.events():
            self._pause(event)
            if self.cancelled.is_set():
                self._bus.publish(EVENTS, _stopped(event))
                return
            if isinstance(event.happening, Perceived):
                self._bus.publish(
                    OBSERVED, made_up_episode.observations(event.happening.frame.counter)
                )
            if isinstance(event.happening, Acted):
                self._bus.publish(MOVED, made_up_episode.motion())
            self._bus.publish(EVENTS, event)


def _stopped(event: Event) -> Event:
    ended = replace(made_up_episode.ended(), outcome="stopped", reason="cancelled")
    return replace(event, happening=ended)


@dataclass(frozen=True)
class MadeUpCell:
    """What a test may look at and break."""

    local: LocalCell
    operator: LocalBus
    executor: MadeUpExecutor
    planner: MadeUpPlanner
    hosts: dict[str, Host]
    buses: dict[str, LocalBus]

    def kill(self, service: str) -> None:
        """Its token goes, as when its process dies."""
        self.buses[service].close()


def at_once(event: Event) -> None:
    """No pause."""


@contextmanager
def made_up_cell(
    folder: Path,
    pause: Callable[[Event], None] = at_once,
    touched: tuple[str, ...] = ("red cylinder",),
) -> Iterator[MadeUpCell]:
    """Four stand-ins that are up, until the block ends."""
    local = LocalCell("made-up")
    buses = {name: LocalBus(local, name) for name in (EXECUTOR, PERCEPTION, BELIEF, PLANNER)}
    journals = {
        name: JournalWriter(folder / f"{name}-{bus.boot[:8]}.journal", name, bus.boot)
        for name, bus in buses.items()
    }
    executor = MadeUpExecutor(touched)
    planner = MadeUpPlanner(JournaledBus(buses[PLANNER], journals[PLANNER]), pause)
    services = {
        EXECUTOR: executor,
        PERCEPTION: Idle(PERCEPTION),
        BELIEF: Idle(BELIEF),
        PLANNER: planner,
    }
    hosts = {name: Host(service, buses[name], journals[name]) for name, service in services.items()}
    threads = [threading.Thread(target=host.work, daemon=True) for host in hosts.values()]
    for host, thread in zip(hosts.values(), threads, strict=True):
        host.announce()
        thread.start()
    yield MadeUpCell(local, LocalBus(local), executor, planner, hosts, buses)
    for host in hosts.values():
        host.end()
    for thread in threads:
        thread.join(2.0)
        assert not thread.is_alive()
