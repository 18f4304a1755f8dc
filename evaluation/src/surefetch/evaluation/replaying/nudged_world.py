"""Live tables on which what is acted on was moved a little, and which keep what came of it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from surefetch.common.cell import InformRow
from surefetch.common.geometry import Array, rotation_angle, rotation_z
from surefetch.common.injections import Injector
from surefetch.common.messages import Grasp
from surefetch.common.streams import stream
from surefetch.evaluation.recordings.measured import Attempt
from surefetch.evaluation.replaying.live_world import LiveWorld
from surefetch.evaluation.replaying.world import Report
from surefetch.evaluation.scenes.generate import GeneratedScene
from surefetch.executor.simulation import scene_bodies
from surefetch.planner import situation
from surefetch.planner.episode_state import EpisodeState

NUDGE_M: Final = 0.002
NUDGE_DEG: Final = 1.0
"""Standard deviations of the move of a body before it is acted on, along x, y and about z."""
DEEPEST_M: Final = 0.001
"""A nudge that would press two bodies deeper into each other than this is not made."""


class Nudged(LiveWorld):
    """A table on which what is acted on was moved a little, and which keeps the attempts at it."""

    def __init__(
        self, made: GeneratedScene, errand: situation.Errand, perception: str, attempt: int
    ) -> None:
        super().__init__(made, errand, perception, Injector())
        self._dice = stream(made.scene.family, made.scene.seed, "outcome", "nudge", attempt)
        self.attempts: list[Attempt] = []

    def nudge(self, name: str) -> None:
        """Move a thing a little, but not into another."""
        x, y = self._dice.normal(0.0, NUDGE_M, 2)
        self.shift(name, (x, y), float(self._dice.normal(0.0, NUDGE_DEG)))

    def shift(self, name: str, by_m: tuple[float, float], turned_deg: float) -> bool:
        """Move a thing along x and y and turn it upright; False: it would be in another."""
        world = self.simulated.world
        T_world_thing = world.pose(name)
        moved = T_world_thing.copy()
        moved[:3, :3] = rotation_z(float(np.radians(turned_deg))) @ T_world_thing[:3, :3]
        moved[:3, 3] += (*by_m, 0.0)
        deepest_m = world.deepest_overlap_m()
        world.put(name, moved)
        is_clear = world.deepest_overlap_m() <= max(deepest_m, DEEPEST_M)
        if not is_clear:
            world.put(name, T_world_thing)
        return is_clear

    def _attempt(self, report: Report, before: Mapping[str, Array], carried: str) -> None:
        moved = [
            _moved(T, self.simulated.world.pose(name))
            for name, T in before.items()
            if not (report.done and name == carried)
        ]
        self.attempts.append(
            Attempt(
                done=report.done,
                why="" if report.done else report.why,
                moved_m=max((m for m, _ in moved), default=0.0),
                turned_deg=max((deg for _, deg in moved), default=0.0),
                duration_s=report.duration_s,
            )
        )

    def _poses(self) -> dict[str, Array]:
        """Of everything that can be moved, the lid too."""
        world = self.simulated.world
        return {thing.name: world.pose(thing.name) for thing in world.things if thing.mass_kg > 0.0}


class RemovalMeasured(Nudged):
    """Its cover is removed by the robot."""

    def inform(self, row: InformRow) -> Report:
        """Remove the cover."""
        self.nudge(scene_bodies.LID)
        before = self._poses()
        report = super().inform(row)
        done = report.done and not self.simulated.covered()
        report = replace(report, done=done)
        self._attempt(report, before, carried=scene_bodies.LID)
        return report


class GraspMeasured(Nudged):
    """Its cover is taken off by hand, and its target grasped by the robot."""

    def inform(self, row: InformRow) -> Report:
        """Look from elsewhere, or find the cover gone."""
        if row.kind == "remove_cover":
            self.lift_lid()
            return Report(done=True)
        return super().inform(row)

    def grasp(self, grasp: Grasp, state: EpisodeState) -> Report:
        """Grasp, lift and verify."""
        track = next(t for t in state.estimate.tracks if t.id == grasp.track)
        target = self.bodies[track.last_detection]
        assert target is not None, "what is instructed to be grasped is a body"
        self.nudge(target)
        before = self._poses()
        report = super().grasp(grasp, state)
        if report.done and self.simulated.held() != target:
            report = replace(report, done=False, why="it does not hold the target")
        self._attempt(report, before, carried=target)
        return report


def _moved(T_before: Array, T_after: Array) -> tuple[float, float]:
    """How far, in metres, and by how much, in degrees."""
    turned = rotation_angle(T_before[:3, :3].T @ T_after[:3, :3])
    return float(np.linalg.norm(T_after[:3, 3] - T_before[:3, 3])), float(np.degrees(turned))
