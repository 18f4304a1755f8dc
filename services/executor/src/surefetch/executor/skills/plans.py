"""Plans made for one estimate and one pose of the arm, kept until either changes.

`feasible` makes them and `execute` drives the same ones, so that what was promised is what is done,
and nothing is planned twice.
"""

import hashlib
from collections.abc import Callable, Hashable
from typing import TypeVar

import numpy as np

from surefetch.common import codec
from surefetch.common.messages import Estimate
from surefetch.common.topics import EXECUTE
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.skills.lid_removal import LidRemoval, plan_lid_removal
from surefetch.executor.skills.pick import Pick
from surefetch.executor.skills.situation import Situation, Workcell, surroundings
from surefetch.executor.skills.steps import Step
from surefetch.executor.skills.target_pick import Tried, plan_target

JOINTS_DIGITS = 3
"""Joints that agree to so many digits (in radians) are the same pose."""

P = TypeVar("P")
Target = tuple[Pick | None, Tried]


class Plans:
    """Plans on demand; the same question gets the same plan while nothing has changed."""

    def __init__(self, workcell: Workcell) -> None:
        self._workcell = workcell
        self._moment: Hashable = None
        self._made: dict[Hashable, object] = {}

    def target(self, now: Situation, track: int, rng: np.random.Generator) -> Target:
        """How to take a track, or why not."""
        around = self.around(now)
        return self._kept(
            now,
            ("target", track),
            lambda: plan_target(self._workcell, now, track, around, rng),
        )

    def lid(self, now: Situation, rng: np.random.Generator) -> LidRemoval | Infeasible:
        """How to take the lid off, or why not."""
        around = self.around(now)
        return self._kept(
            now,
            "lid",
            lambda: _or_refusal(lambda: plan_lid_removal(self._workcell, now, around, rng)),
        )

    def view(self, now: Situation, view: str, rng: np.random.Generator) -> Step | Infeasible:
        """How to bring the camera to a view, or why not."""
        row, around = self._workcell.cell.view(view), self.around(now)

        def plan() -> Step:
            tool = now.tool()
            to_it = self._workcell.motion.to_view(now.q_rad, row, around, tool, rng)
            return Step(f"to view {view}", to_it, tool, around)

        return self._kept(now, ("view", view), lambda: _or_refusal(plan))

    def around(self, now: Situation) -> CollisionScene:
        """`surroundings` of now, made once."""
        return self._kept(now, "around", lambda: surroundings(self._workcell, now))

    def _kept(self, now: Situation, key: Hashable, make: Callable[[], P]) -> P:
        moment = _moment_of(now)
        if moment != self._moment:
            self._moment, self._made = moment, {}
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]  # type: ignore[return-value]


def _or_refusal(make: Callable[[], P]) -> P | Infeasible:
    try:
        return make()
    except Infeasible as refusal:
        return refusal


def _moment_of(now: Situation) -> Hashable:
    """Everything that a plan depends on, in short."""
    joints = tuple(np.round(now.q_rad, JOINTS_DIGITS).tolist())
    width = round(now.width_m, JOINTS_DIGITS)
    return _digest(now.estimate), joints, width, now.memory


def _digest(estimate: Estimate) -> bytes:
    encoded = codec.encode(estimate, max_bytes=EXECUTE.max_request_bytes)
    return hashlib.blake2b(encoded, digest_size=16).digest()
