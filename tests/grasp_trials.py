"""Grasp trials on the real parts: perception and the executor's service, no belief, no planner.

The simulator's truth says which candidate is the target and how it ended; nothing that plans or
moves is told.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TypeVar

import numpy as np
from grasp_scenes import Trial

from surefetch.common import mask
from surefetch.common.cell import simulated_cell
from surefetch.common.local_bus import LocalBus, LocalCell
from surefetch.common.messages import (
    AskFeasible,
    AskTruth,
    Capture,
    Command,
    Deliver,
    Detection,
    Estimate,
    Frame,
    Grasp,
    Look,
    Observations,
    Target,
    Track,
    Verb,
)
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.common.topics import EXECUTOR, FRAME
from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.service import ExecutorService
from surefetch.executor.simulation.pybullet_cell import PybulletCell
from surefetch.executor.simulation.pybullet_devices import pybullet_devices
from surefetch.executor.simulation.scorer_questions import Simulation
from surefetch.executor.skills.situation import Workcell
from surefetch.perception.classical import classical_backend
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.observe import observe
from surefetch.perception.reply import reply

T = TypeVar("T")
VIEWS = ("center", "close_high", "right")
UNSEEN = Estimate(
    tracks=(),
    container=None,
    cover="unknown",
    obstacles=(),
    obstacle_points_world_m=np.zeros((0, 3), np.float32),
)
LOOKING = Capture(episode="trial", step=0)
ANYTHING = Target(noun="object")
LIFTED_M = 0.05
DELIVERED_M = 0.15
"""From the place's middle: it may have had to be put beside it."""


@dataclass(frozen=True)
class Result:
    """How one trial ended; `cause` is empty when the object was lifted and delivered."""

    trial: Trial
    cause: str
    why: str
    seconds: dict[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        one = self.trial.target
        size = " x ".join(f"{1e3 * v:.0f}" for v in one.size_m)
        x, y, _ = one.position_world_m
        where = f"{self.trial.where} {self.trial.scene.seed}: {one.shape} {size} mm"
        return f"{where} at ({x:.2f}, {y:.2f}) m, {one.mass_kg:.2f} kg: {self.cause}: {self.why}"


class _Ended(Exception):
    def __init__(self, cause: str, why: str) -> None:
        super().__init__(why)
        self.cause = cause


class Bench:
    """A simulated cell, served by the executor; close it."""

    def __init__(self) -> None:
        cell = simulated_cell()
        self._place = cell.delivery
        self._simulated = PybulletCell(cell)
        self._geometry = LatestGeometry()
        self._backend = classical_backend(self._geometry)
        self._executor = ExecutorService(
            Workcell.of(cell, AntipodalProposer()),
            pybullet_devices(self._simulated),
            LocalBus(LocalCell("grasp trials"), EXECUTOR),
            backend="pybullet",
            simulated=Simulation(self._simulated),
        )
        self._handles = {handle.topic.verb: handle.answer for handle in self._executor.handles}
        self._commands = 0
        self._seconds: dict[str, float] = {}

    def close(self) -> None:
        """End the simulation."""
        self._simulated.close()

    def attempt(self, trial: Trial) -> Result:
        """Look until the target can be grasped, grasp it, deliver it."""
        self._seconds = {}
        cause, why = "", "delivered"
        try:
            self._fetch(trial)
        except _Ended as ended:
            cause, why = ended.cause, str(ended)
        return Result(trial, cause, why, self._seconds)

    def _fetch(self, trial: Trial) -> None:
        self._timed("load", lambda: self._executor.load_scene(trial.scene))
        estimate, track = self._found(trial)
        stood_at_m = self._height_m()
        self._do("grasp", Grasp(track=track, relation="outside"), estimate)
        lifted = self._height_m() - stood_at_m
        if lifted < LIFTED_M:
            held = self._truth_held()
            raise _Ended("not lifted", f"it rose by {1e3 * lifted:.0f} mm; {held} is in the hand")
        self._do("deliver", Deliver(place=self._place.name), estimate)
        position = self._executor.truth(AskTruth()).bodies[0].position_world_m
        off = float(np.linalg.norm(np.subtract(position, self._place.position_m)[:2]))
        if off > DELIVERED_M or self._truth_held() == trial.target.name:
            raise _Ended("not delivered", f"it ended {1e3 * off:.0f} mm from the place")

    def _found(self, trial: Trial) -> tuple[Estimate, int]:
        """The estimate of the first view from which the target was seen and can be grasped."""
        cause, why, estimate = "not seen", "no candidate shows it", UNSEEN
        for view in VIEWS:
            self._do("look", Look(view=view), estimate)
            seen, target = self._perceived()
            estimate = _estimate_of(seen)
            if target is None or target.center_world_m is None:
                continue
            track = seen.detections.index(target)
            ask = AskFeasible(
                episode="trial", step=0, estimate=estimate, grasps=(track,), informs=()
            )
            verdict = self._timed("plan", partial(self._executor.feasible, ask)).grasps[0]
            if verdict.feasible:
                return estimate, track
            cause, why = f"refused: {verdict.refusal}", f"{verdict.why} {verdict.tried}"
        raise _Ended(cause, why)

    def _perceived(self) -> tuple[Observations, Detection | None]:
        """What is seen from here, and which detection shows the target (by the truth)."""
        info = self._timed("capture", lambda: self._executor.capture(LOOKING))
        frame = self._handles[FRAME.verb](info.frame)
        assert isinstance(frame, Frame)
        rgbd = RgbdFrame(frame.rgb, frame.depth_m, info.K, info.T_world_camera, info.view)
        perceived = self._timed(
            "perceive", lambda: observe(rgbd, ANYTHING, self._backend, self._geometry)
        )
        seen = reply(perceived, info.frame, self._backend.name, duration_s=0.0)
        segments = self._executor.truth(AskTruth(frame=info.frame)).segmentation
        assert segments is not None
        shown = [segments[mask.decode(one.mask)] == 0 for one in seen.detections]
        ours = [i for i, pixels in enumerate(shown) if len(pixels) and pixels.mean() > 0.5]
        best = max(ours, key=lambda i: int(shown[i].sum()), default=None)
        return seen, None if best is None else seen.detections[best]

    def _do(self, label: str, verb: Verb, estimate: Estimate) -> None:
        self._commands += 1
        command = Command(
            cmd_id=f"c{self._commands}", episode="trial", step=0, verb=verb, estimate=estimate
        )
        outcome = self._timed(label, lambda: self._executor.execute(command))
        if outcome.status != "done":
            raise _Ended(f"{label} {outcome.status}", f"{outcome.why} {outcome.checks}")

    def _height_m(self) -> float:
        return self._executor.truth(AskTruth()).bodies[0].position_world_m[2]

    def _truth_held(self) -> str | None:
        return self._executor.truth(AskTruth()).held

    def _timed(self, label: str, do: Callable[[], T]) -> T:
        began = time.perf_counter()
        try:
            return do()
        finally:
            took = time.perf_counter() - began
            self._seconds[label] = self._seconds.get(label, 0.0) + took


def _estimate_of(seen: Observations) -> Estimate:
    """What the belief would make of one frame: every detection with a centre a track."""
    tracks = [
        Track(
            id=i,
            center_world_m=one.center_world_m,
            solid=one.solid,
            points_world_m=one.points_world_m,
            hist=one.hist,
            n_observations=1,
            y0=None,
            last_detection=one.id,
            last_step=0,
        )
        for i, one in enumerate(seen.detections)
        if one.center_world_m is not None
    ]
    return Estimate(
        tracks=tuple(tracks),
        container=seen.container,
        cover=seen.cover,
        obstacles=seen.obstacles,
        obstacle_points_world_m=seen.obstacle_points_world_m,
    )
