"""Situations of recorded scenes, and which options were right in each of them, in hindsight.

Reads the truth. Every sequence of looks is followed with actions that never fail; what a failed
grasp costs is counted as expected.

An information action is right where acting at once would not do, and it can lead to where the most
probable grasp is that of the target, at less cost. Acting at once means grasping the most
probable, or deferring: grasping the second is right where that is the target, but nobody would
without a look, and if it stood against looking, doubt would never call for a look.

Source: EVALUATION, IntroPlan.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.messages import Inform
from surefetch.evaluation.policies.fixed_sequence import FixedSequence
from surefetch.evaluation.policies.introplan_situation import (
    LOOK,
    NOT_LISTED,
    OPEN,
    OPTIONS,
    Mask,
    candidates,
    choices,
)
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.policies.registry import Entry
from surefetch.evaluation.recordings.recording import Path, paths, state_after
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.episode import OUT_OF_RECORDING
from surefetch.evaluation.replaying.evaluate import Conditions, world_of
from surefetch.evaluation.replaying.hindsight import DEFERS
from surefetch.evaluation.replaying.outcomes import Rates
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.sitting import Sitting
from surefetch.evaluation.replaying.world import OutOfRecording
from surefetch.planner.actions import Costs, defer_cost, grasp_cost

NEVER_FAILS: Final = Conditions(rates=Rates(remove=1.0, view=1.0, grasp=1.0))


@dataclass(frozen=True, eq=False)
class Met:
    """One situation of a scene, and what grasping in it would come to."""

    path: Path
    """The information actions that lead to it."""
    now: Observation
    view: str
    """Of the latest look."""
    on_target: tuple[bool, bool]
    """Whether grasping the first, and the second, is open and would be right."""


@dataclass(frozen=True, eq=False)
class Lesson:
    """One situation, and what was right in it."""

    met: Met
    right: Mask
    """(options,); never empty"""


def lessons_of(scene: RecordedScene, one: Contender, cell: Cell) -> list[Lesson]:
    """Of every situation that a sequence of looks leads to, the first look's first."""
    met = met_in(scene, one, cell)
    present = scene.truth.target is not None
    return [Lesson(now, right_in(now.path, met, cell, present=present)) for now in met.values()]


def met_in(scene: RecordedScene, one: Contender, cell: Cell) -> dict[Path, Met]:
    """Every situation, each after those before it. One that the robot cannot reach is left out.

    Raises:
        OutOfRecording: a state was not recorded.
    """
    covered = scene.recording.covered
    begin = partial(Sitting.begin, scene=scene, cell=cell)
    beliefs = begin(one).beliefs()
    found: dict[Path, Met] = {}
    for path in paths(covered, cell, views_while_covered=one.profile.views_while_covered):
        along = replace(one, entry=Entry(partial(FixedSequence, path, DEFERS)))
        played = begin(along).play(world_of(scene, NEVER_FAILS), beliefs)
        if played.end.reason == OUT_OF_RECORDING:
            raise OutOfRecording(played.end.because)
        now = played.moments[-1].now
        if now is not None and now.used == set(path):
            view = state_after(path, covered, cell).view
            found[path] = Met(path, now, view, _on_target(now, scene))
    return found


def right_in(path: Path, met: Mapping[Path, Met], cell: Cell, *, present: bool) -> Mask:
    """(options,): what is right after these looks. See the module.

    Args:
        path: the looks.
        met: all situations of the scene.
        cell: the robot's.
        present: whether the target is on the table.
    """
    here = met[path]
    at_once = _cost_at_once(here, present=present)
    right = np.zeros(len(OPTIONS), bool)
    right[:2] = here.on_target
    for option in (LOOK, OPEN):
        choice = choices(here.now)[option]
        if isinstance(choice, Inform):
            on = (*path, choice.name)
            ends = [m for p, m in met.items() if p[: len(on)] == on and m.on_target[0]]
            costs = [_cost_of(end.path[len(path) :], end, cell) for end in ends]
            right[option] = min(costs, default=np.inf) < at_once
    right[NOT_LISTED] = not present or not right.any()
    return right


def _cost_at_once(here: Met, *, present: bool) -> float:
    """Expected, of the better of grasping the most probable and deferring, as it truly is."""
    costs = Costs()
    defer = defer_cost(float(not present), costs)
    return min(defer, grasp_cost(float(here.on_target[0]), _p_grasp(here), costs))


def _cost_of(actions: Path, end: Met, cell: Cell) -> float:
    looks = sum(cell.inform(name).cost for name in actions)
    return looks + grasp_cost(1.0, _p_grasp(end), Costs())


def _p_grasp(met: Met) -> float:
    return met.now.parameters.priors.p_grasp


def _on_target(now: Observation, scene: RecordedScene) -> tuple[bool, bool]:
    under = {t.id: scene.bodies[t.last_detection] for t in now.believed.tracks}
    target = scene.truth.target
    best = [
        one.open and target is not None and under[one.track] == target
        for one in candidates(now)[:2]
    ]
    first, second, *_ = [*best, False, False]
    return first, second
