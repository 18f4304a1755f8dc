"""Perception on the bus: it fetches a frame by its id, answers, and publishes the same."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from queue import Queue
from typing import Any

import numpy as np
import pytest
from rendered import shoot
from tabletop import body, box, scene

from surefetch.common import codec
from surefetch.common.errors import Refused
from surefetch.common.journal import JournalWriter
from surefetch.common.local_bus import LocalBus, LocalCell
from surefetch.common.messages import (
    Empty,
    Frame,
    FrameId,
    FrameInfo,
    Observations,
    Observe,
    Target,
)
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.common.runner import Handle, Host
from surefetch.common.topics import (
    EXECUTOR,
    FRAME,
    OBSERVE,
    OBSERVED,
    PERCEPTION,
    PLANNER,
    VOCABULARY,
)
from surefetch.perception.classical import VOCABULARY as CLASSICAL
from surefetch.perception.classical import classical_backend
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.service import PerceptionService

TARGET = Target(noun="cube", color="red", shape="cube", relation="outside")


class Album:
    """An executor that has taken some pictures and does nothing else."""

    name, backend, doing = EXECUTOR, "album", "idle"

    def __init__(self, boot: str, frames: tuple[RgbdFrame, ...]) -> None:
        self._frames = {FrameId(boot=boot, counter=i): one for i, one in enumerate(frames, 1)}

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        return (Handle(FRAME, self.frame, concurrent=True),)

    def frame(self, wanted: FrameId) -> Frame:
        if wanted not in self._frames:
            raise Refused("NO_SUCH_FRAME", f"there is no frame {wanted.counter}")
        one = self._frames[wanted]
        height, width = one.depth_m.shape
        info = FrameInfo(
            frame=wanted,
            view=one.view,
            width=width,
            height=height,
            K=one.K,
            T_world_camera=np.eye(4) if one.T_world_camera is None else one.T_world_camera,
            captured_s=1.0,
        )
        return Frame(
            info=info, rgb=one.rgb, depth_m=one.depth_m, q_rad=(0.0,) * 6, gripper_width_m=0.1
        )


@contextmanager
def served(folder: Path, *frames: RgbdFrame) -> Iterator[tuple[LocalBus, str, Queue[Observations]]]:
    """A planner's bus in a cell with that album and perception; the album's boot; what is heard."""
    cell = LocalCell()
    album_bus, bus = LocalBus(cell, EXECUTOR), LocalBus(cell, PERCEPTION)
    geometry = LatestGeometry()
    perception = PerceptionService(bus, classical_backend(geometry), geometry)
    hosts = [
        Host(service, on, JournalWriter(folder / f"{service.name}.journal", service.name, on.boot))
        for service, on in ((Album(album_bus.boot, frames), album_bus), (perception, bus))
    ]
    threads = [threading.Thread(target=host.work, daemon=True) for host in hosts]
    for host, thread in zip(hosts, threads, strict=True):
        host.announce()
        thread.start()
    heard: Queue[Observations] = Queue()
    LocalBus(cell).listen(OBSERVED, heard.put)
    yield LocalBus(cell, PLANNER), album_bus.boot, heard
    for host, thread in zip(hosts, threads, strict=True):
        host.end()
        thread.join(5.0)
        host.close()


def observe(boot: str, counter: int) -> Observe:
    return Observe(
        episode="e", step=counter, frame=FrameId(boot=boot, counter=counter), target=TARGET
    )


def test_a_frame_is_fetched_perceived_answered_and_published(tmp_path: Path) -> None:
    table = scene(body("a", at_m=(0.84, -0.15)), container=box(covered=False))
    with served(tmp_path, shoot(table).frame, shoot(table, "right").frame) as (bus, boot, heard):
        seen = [bus.ask(OBSERVE, observe(boot, counter), timeout_s=20.0) for counter in (1, 2)]
        told = [heard.get(timeout=5.0) for _ in seen]
    for counter, (one, same) in enumerate(zip(seen, told, strict=True), 1):
        assert one.frame == FrameId(boot=boot, counter=counter)
        assert one.backend == CLASSICAL.backend
        assert one.cover == "open"
        assert one.container is not None
        assert [d.answers.membership.label for d in one.detections if d.answers] == ["outside"]
        assert codec.encode(one, max_bytes=2**24) == codec.encode(same, max_bytes=2**24)
    ids = [detection.id for one in seen for detection in one.detections]
    assert len(set(ids)) == len(ids) == 2


def test_the_vocabulary_is_told(tmp_path: Path) -> None:
    with served(tmp_path) as (bus, _, _):
        assert bus.ask(VOCABULARY, Empty(), timeout_s=5.0) == CLASSICAL


def test_a_frame_that_is_not_there_is_refused_and_the_next_one_served(tmp_path: Path) -> None:
    shot = shoot(scene(body("a", at_m=(0.84, -0.15))))
    with served(tmp_path, shot.frame) as (bus, boot, _):
        with pytest.raises(Refused, match="there is no frame 7"):
            bus.ask(OBSERVE, observe(boot, 7), timeout_s=20.0)
        assert len(bus.ask(OBSERVE, observe(boot, 1), timeout_s=20.0).detections) == 1


def test_a_frame_without_a_support_is_refused_in_words(tmp_path: Path) -> None:
    shot = shoot(scene(body("a", at_m=(0.84, -0.15))))
    blind = RgbdFrame(
        shot.frame.rgb, np.zeros_like(shot.frame.depth_m), shot.frame.K, shot.frame.T_world_camera
    )
    with (
        served(tmp_path, blind) as (bus, boot, _),
        pytest.raises(Refused, match="no support plane is visible"),
    ):
        bus.ask(OBSERVE, observe(boot, 1), timeout_s=20.0)
