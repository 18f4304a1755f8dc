"""The executor as a process of its own, over real Zenoh: what only a process can show."""

import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from tabletop import body, estimate_of, scene

from surefetch.common.errors import InfrastructureError
from surefetch.common.journal import read_journal
from surefetch.common.launch import Launch, Services, own_cell_name
from surefetch.common.messages import (
    AskTruth,
    Capture,
    Command,
    Look,
    Motion,
    Outcome,
    Stop,
)
from surefetch.common.settings import BusSettings
from surefetch.common.topics import (
    CAPTURE,
    EXECUTE,
    EXECUTOR,
    FRAME,
    LOAD_SCENE,
    MOVED,
    STOP,
    TRUTH,
)
from surefetch.common.zenoh_bus import ZenohBus

TABLE = scene(body("cube"))


@dataclass(frozen=True)
class Executor:
    """A process with a scene loaded, and a bus to it."""

    services: Services
    bus: ZenohBus
    folder: Path

    def look(self, cmd_id: str, view: str) -> Outcome:
        command = Command(
            cmd_id=cmd_id, episode="e", step=0, verb=Look(view=view), estimate=estimate_of(TABLE)
        )
        return self.bus.ask(EXECUTE, command, timeout_s=30.0)


@contextmanager
def executor(folder: Path, *options: str) -> Iterator[Executor]:
    launch = Launch(
        services=(EXECUTOR,),
        cell=own_cell_name(),
        folder=folder,
        options=("--journal-dir", str(folder / "journal"), *options),
    )
    with Services.start(launch) as services:
        settings = BusSettings(launch.cell, connect=services.endpoints)
        with closing(ZenohBus(settings)) as bus:
            bus.ask(LOAD_SCENE, TABLE, timeout_s=30.0)
            yield Executor(services, bus, folder / "journal")


@pytest.mark.system
def test_frames_outcomes_and_truth_travel(tmp_path: Path) -> None:
    with executor(tmp_path) as one:
        moved: list[Motion] = []
        one.bus.listen(MOVED, moved.append)
        assert one.look("a", "center").status == "done"
        info = one.bus.ask(CAPTURE, Capture(episode="e", step=0), timeout_s=10.0)
        frame = one.bus.ask(FRAME, info.frame, timeout_s=10.0)
        truth = one.bus.ask(TRUTH, AskTruth(frame=info.frame), timeout_s=10.0)
        assert frame.rgb.shape == (info.height, info.width, 3)
        assert truth.segmentation is not None and (truth.segmentation == 0).sum() > 100
        assert [motion.label for motion in moved] == ["to view center"]


@pytest.mark.system
def test_a_stop_is_heard_in_mid_motion_and_frames_are_served_meanwhile(tmp_path: Path) -> None:
    with executor(tmp_path, "--real-time") as one:
        info = one.bus.ask(CAPTURE, Capture(episode="e", step=0), timeout_s=10.0)
        outcomes: list[Outcome] = []
        thread = threading.Thread(target=lambda: outcomes.append(one.look("a", "center")))
        thread.start()
        time.sleep(0.8)
        began = time.monotonic()
        assert one.bus.ask(FRAME, info.frame, timeout_s=2.0).info.frame == info.frame
        stopped = one.bus.ask(STOP, Stop(who="the test"), timeout_s=2.0)
        thread.join(5.0)
        assert time.monotonic() - began < 1.0
        assert stopped.was_moving and stopped.took_s < 0.5
        assert outcomes[0].status == "stopped"
        assert one.look("b", "right").status == "stopped"


@pytest.mark.system
def test_told_to_end_in_mid_motion_it_stops_journals_and_leaves_within_3_s(tmp_path: Path) -> None:
    with executor(tmp_path, "--real-time") as one:
        thread = threading.Thread(target=lambda: _ask_in_vain(one))
        thread.start()
        time.sleep(0.8)
        began = time.monotonic()
        one.services.close()
        assert time.monotonic() - began < 3.0
        thread.join(5.0)
        (path,) = one.folder.glob("executor-*.journal")
    replies = [
        r for r in read_journal(path).records if r.topic == EXECUTE.name and r.kind == "reply"
    ]
    outcome = replies[-1].message(Outcome)
    assert outcome.status == "stopped"
    assert len(outcome.motions[-1].times_s) > 0 and np.isfinite(outcome.motions[-1].q_rad).all()


def _ask_in_vain(one: Executor) -> None:
    """The answer may still come, or the process is gone before."""
    with suppress(InfrastructureError):
        one.look("a", "center")
