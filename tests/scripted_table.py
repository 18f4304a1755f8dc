"""A table by script: what can be seen from where, and what goes wrong, answered as services would.

Executor and perception answer with real messages over the real codec; belief and planner are the
real ones. Nothing is simulated: a thing is where it is, and is read as the script says.
"""

import queue
import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from surefetch.belief.service import BeliefService
from surefetch.common.cell import simulated_cell
from surefetch.common.geometry import intrinsics, look_at
from surefetch.common.journal import Journal, JournalWriter, read_journal
from surefetch.common.local_bus import LocalBus, LocalCell
from surefetch.common.messages import (
    Accepted,
    Answer,
    Answers,
    AskFeasible,
    Box3d,
    Cancel,
    Capture,
    Command,
    ContainerReading,
    CoverState,
    Deliver,
    Detection,
    Empty,
    Ended,
    Event,
    Feasibility,
    FrameId,
    FrameInfo,
    Grasp,
    GraspVerdict,
    Inform,
    InformVerdict,
    Instruct,
    Lid,
    Look,
    Mask,
    Observations,
    Observe,
    Outcome,
    PutBack,
    Vocabulary,
)
from surefetch.common.parameters import PRINTED, Calibration, Parameters, Provenance
from surefetch.common.runner import Handle, Host, JournaledBus, Service
from surefetch.common.topics import (
    BELIEF,
    CANCEL,
    CAPTURE,
    EVENTS,
    EXECUTE,
    EXECUTOR,
    FEASIBLE,
    INSTRUCT,
    OBSERVE,
    PERCEPTION,
    PLANNER,
    VOCABULARY,
)
from surefetch.planner.service import PlannerService

CELL = simulated_cell()
VIEWS = tuple(view.name for view in CELL.views)
BACKEND = "scripted"
Reading = Literal["match", "other", "unread", "hidden"]
"""How a thing is read from a view; hidden: not detected."""
LABEL = {"match": "supported", "other": "contradicted", "unread": "unobservable"}
INSIDE_M = (1.0, 0.0)
NO_POINTS = np.zeros((0, 3), np.float32)
PLATE = Box3d(center_world_m=(1.0, 0.0, 0.09), size_m=(0.25, 0.25, 0.01), yaw_rad=0.0)


def parameters(profile: str, q_hat: float = 0.9) -> Parameters:
    """Numbers of a perception that is right nearly always, and says so when it cannot read."""
    origin = Provenance(
        cell=CELL.name, backend=BACKEND, split="none", n_episodes=0, seeds="", note="for tests"
    )
    rows: dict[str, tuple[int, ...]] = {
        "target_inside": (80, 1, 6, 1, 12, 1, 3),
        "target_outside": (1, 80, 6, 1, 1, 12, 3),
        "distractor": (1, 1, 1, 90, 6, 6, 2),
    }
    conditions = dict.fromkeys(["center", "after_removal", "close_high", "right"], rows)
    calibration = Calibration(
        q_hat=q_hat, alpha="0.1", scores=None, coverage_range=(0.0, 1.0), provenance=origin
    )
    return Parameters(
        profile=profile,
        fitted_on=origin,
        priors=PRINTED,
        emissions=conditions,
        paired={},
        calibrations={"full": calibration},
    )


@dataclass(frozen=True)
class Thing:
    """One object, and how it is read from each view."""

    at_m: tuple[float, float]
    reads: Mapping[str, Reading]
    inside: bool = False

    @property
    def center_world_m(self) -> tuple[float, float, float]:
        return (*self.at_m, 0.03)


def thing(x_m: float, y_m: float, reading: Reading = "match", **by_view: Reading) -> Thing:
    """A thing beside the box, read the same from everywhere but where it is said otherwise."""
    return Thing((x_m, y_m), dict.fromkeys(VIEWS, reading) | by_view)


def thing_inside(reading: Reading = "match", **by_view: Reading) -> Thing:
    """The same in the box."""
    return Thing(INSIDE_M, dict.fromkeys(VIEWS, reading) | by_view, inside=True)


@dataclass
class Table:
    """What stands there, and the script of what goes wrong."""

    things: Sequence[Thing]
    covered: bool | None = False
    """None: there is no box."""
    fails: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """By action: what becomes of its first, second … try. Afterwards all is well."""
    stuck_lid: bool = False
    """Removals report success, and the box stays covered."""
    infeasible: frozenset[str] = frozenset()
    """Information actions, and "grasp"."""
    slips: int = 0
    """So many grasps report success with the thing still in its place."""
    on_execute: Callable[[Command], None] = lambda command: None

    view: str | None = None
    held: Thing | None = None
    gone: list[Thing] = field(default_factory=list)
    """Grasped, in order."""
    executed: list[Command] = field(default_factory=list)
    n_frames: int = 0
    frames: dict[int, str | None] = field(default_factory=dict)

    def visible(self, view: str | None) -> list[Thing]:
        """What can be detected from a view."""
        hidden = [] if not self.covered else [t for t in self.things if t.inside]
        return [
            t
            for t in self.things
            if t not in hidden
            and t not in self.gone
            and view is not None
            and t.reads[view] != "hidden"
        ]

    @property
    def seen_cover(self) -> CoverState:
        if self.covered is None:
            return "unknown"
        return "covered" if self.covered else "open"


class ScriptedExecutor:
    """Does as the script says."""

    name, backend, doing = EXECUTOR, BACKEND, "follows a script"

    def __init__(self, table: Table, boot: str) -> None:
        self._table = table
        self._boot = boot

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        return (
            Handle(CAPTURE, self.capture),
            Handle(FEASIBLE, self.feasible),
            Handle(EXECUTE, self.execute),
        )

    def capture(self, _: Capture) -> FrameInfo:
        table = self._table
        table.frames[table.n_frames] = table.view
        frame = FrameId(boot=self._boot, counter=table.n_frames)
        table.n_frames += 1
        eye, target, up = np.array([0.5, 0.0, 0.6]), np.array([1.0, 0.0, 0.0]), np.array([0, 0, 1])
        return FrameInfo(
            frame=frame,
            view=table.view,
            width=640,
            height=480,
            K=intrinsics(640, 480, 60.0),
            T_world_camera=look_at(eye, target, up.astype(float)),
            captured_s=float(frame.counter),
        )

    def feasible(self, ask: AskFeasible) -> Feasibility:
        out = self._table.infeasible
        grasps = tuple(
            GraspVerdict(
                track=track,
                feasible="grasp" not in out,
                refusal="aperture" if "grasp" in out else None,
                why="too wide" if "grasp" in out else "",
                tried={},
            )
            for track in ask.grasps
        )
        informs = tuple(
            InformVerdict(
                name=name,
                feasible=name not in out,
                refusal="reach" if name in out else None,
                why="",
            )
            for name in ask.informs
        )
        return Feasibility(grasps=grasps, informs=informs, duration_s=0.0)

    def execute(self, command: Command) -> Outcome:
        table = self._table
        table.executed.append(command)
        table.on_execute(command)
        status = self._status(command)
        if status == "done":
            self._do(command)
        elif not isinstance(command.verb, Deliver | PutBack):
            table.view = None
        return Outcome(
            cmd_id=command.cmd_id,
            status=status,  # type: ignore[arg-type]
            refusal="path" if status == "refused" else None,
            why="" if status == "done" else "as the script says",
            checks={},
            gripper_width_m=0.05,
            holding=table.held is not None,
            duration_s=1.0,
            planning_s=0.0,
            motions=(),
        )

    def _status(self, command: Command) -> str:
        name = action(command)
        nth = sum(action(c) == name for c in self._table.executed) - 1
        script = self._table.fails.get(name, ())
        return script[nth] if nth < len(script) else "done"

    def _do(self, command: Command) -> None:
        table = self._table
        match command.verb:
            case Inform(name=name):
                row = CELL.inform(name)
                table.view = row.view
                if row.kind == "remove_cover" and not table.stuck_lid:
                    table.covered = False
            case Look(view=view):
                table.view = view
            case Grasp(track=number):
                table.view = None
                self._grasp(next(t for t in command.estimate.tracks if t.id == number))
            case Deliver() | PutBack():
                table.held = None

    def _grasp(self, track: Any) -> None:
        table = self._table
        table.held = min(
            table.things,
            key=lambda t: float(np.hypot(*np.subtract(t.at_m, track.center_world_m[:2]))),
        )
        if table.slips > 0:
            table.slips -= 1
        else:
            table.gone.append(table.held)


class ScriptedPerception:
    """Reads things as the script says; knows only from where a frame was taken."""

    name, backend, doing = PERCEPTION, BACKEND, "follows a script"

    def __init__(self, table: Table) -> None:
        self._table = table

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        return (
            Handle(VOCABULARY, self.vocabulary, concurrent=True),
            Handle(OBSERVE, self.observe),
        )

    def vocabulary(self, _: Empty) -> Vocabulary:
        return Vocabulary(
            backend=BACKEND,
            open=False,
            nouns=("object",),
            colors=("red", "blue"),
            shapes=("cube",),
            markings=("plain",),
            containers=("box",),
        )

    def observe(self, ask: Observe) -> Observations:
        view = self._table.frames[ask.frame.counter]
        seen = self._table.visible(view)
        return Observations(
            frame=ask.frame,
            backend=BACKEND,
            detections=tuple(
                _detection(f"{ask.frame.counter}-{n}", t, t.reads[view or ""])
                for n, t in enumerate(seen)
            ),
            container=_container(self._table.covered),
            cover=self._table.seen_cover,
            obstacles=(),
            obstacle_points_world_m=NO_POINTS,
            duration_s=0.0,
        )


def _detection(name: str, seen: Thing, reading: Reading) -> Detection:
    color = Answer(label=LABEL[reading], scores=(0.0, 0.0, 0.0))
    membership = Answer(label="inside" if seen.inside else "outside", scores=(0.0, 0.0, 0.0))
    solid = Box3d(center_world_m=seen.center_world_m, size_m=(0.05, 0.05, 0.06), yaw_rad=0.0)
    return Detection(
        id=name,
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        phrase="thing",
        mask=_NO_MASK,
        group=0,
        representative=True,
        center_world_m=seen.center_world_m,
        solid=solid,
        points_world_m=NO_POINTS,
        hist=None,
        answers=Answers(color=color, shape=None, marking=None, membership=membership),
    )


_NO_MASK = Mask(height=1, width=1, counts=(1,))


def _container(covered: bool | None) -> ContainerReading | None:
    if covered is None:
        return None
    return ContainerReading(
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        mask=_NO_MASK,
        outer=Box3d(center_world_m=(1.0, 0.0, 0.04), size_m=(0.25, 0.25, 0.08), yaw_rad=0.0),
        inner_size_m=(0.24, 0.24),
        floor_z_m=0.005,
        rim_z_m=0.08,
        complete=True,
        lid=Lid(plate=PLATE, knob=None) if covered else None,
    )


def action(command: Command) -> str:
    """The name under which the script knows a command."""
    verb = command.verb
    return verb.name if isinstance(verb, Inform) else type(verb).__name__.lower()


@dataclass(frozen=True, eq=False)
class ScriptedCell:
    """Four services over one table, and an operator."""

    table: Table
    operator: LocalBus
    buses: dict[str, LocalBus]
    journals: dict[str, Path]
    heard: "queue.Queue[Event]"

    def kill(self, service: str) -> None:
        """Its token goes, as when its process dies."""
        self.buses[service].close()

    def instruct(
        self,
        sentence: str = "the red object",
        profile: str = "extended",
        after_grasp: Literal["deliver", "hold", "return"] = "deliver",
    ) -> Accepted:
        policy = {"extended": "ours", "paper": "paper-method"}[profile]
        request = Instruct(
            sentence=sentence, profile=profile, policy=policy, after_grasp=after_grasp
        )
        return self.operator.ask(INSTRUCT, request, timeout_s=10.0)

    def events(self) -> list[Event]:
        """All events of the episode under way, to its end."""
        told = [self.heard.get(timeout=20.0)]
        while not isinstance(told[-1].happening, Ended):
            told.append(self.heard.get(timeout=20.0))
        return told

    def fetch(self, sentence: str = "the red object", profile: str = "extended") -> Ended:
        """One episode; how it ended."""
        self.instruct(sentence, profile)
        ended = self.events()[-1].happening
        assert isinstance(ended, Ended)
        return ended

    def cancel(self, episode: str) -> None:
        self.operator.ask(CANCEL, Cancel(episode=episode), timeout_s=10.0)

    def journal(self, service: str) -> Journal:
        return read_journal(self.journals[service])


@contextmanager
def scripted_cell(table: Table, q_hat: float = 0.9) -> Iterator[ScriptedCell]:
    """A cell over this table, until the block ends."""
    local = LocalCell("scripted")
    buses = {name: LocalBus(local, name) for name in (EXECUTOR, PERCEPTION, BELIEF, PLANNER)}

    def numbers(profile: str) -> Parameters:
        return parameters(profile, q_hat)

    with tempfile.TemporaryDirectory() as folder:
        paths = {name: Path(folder) / f"{name}.journal" for name in buses}
        journals = {name: JournalWriter(paths[name], name, bus.boot) for name, bus in buses.items()}
        services: dict[str, Service] = {
            EXECUTOR: ScriptedExecutor(table, buses[EXECUTOR].boot),
            PERCEPTION: ScriptedPerception(table),
            BELIEF: BeliefService(numbers, CELL.name),
            PLANNER: PlannerService(JournaledBus(buses[PLANNER], journals[PLANNER]), CELL, numbers),
        }
        hosts = [Host(services[name], buses[name], journals[name]) for name in buses]
        threads = [threading.Thread(target=host.work, daemon=True) for host in hosts]
        operator = LocalBus(local)
        heard: queue.Queue[Event] = queue.Queue()
        operator.listen(EVENTS, heard.put)
        for host, thread in zip(hosts, threads, strict=True):
            host.announce()
            thread.start()
        yield ScriptedCell(table, operator, buses, paths, heard)
        for host in hosts:
            host.end()
        for thread in threads:
            thread.join(5.0)
            assert not thread.is_alive()
        for journal in journals.values():
            journal.close()
