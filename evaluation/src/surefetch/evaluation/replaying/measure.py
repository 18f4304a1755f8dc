"""Outcomes by physics: a scene's cover is removed and its target grasped, as the robot does it.

Every attempt begins on a fresh table and goes the robot's own way: look, believe, plan against the
estimate, drive. Only what to do is taken from the truth. The body that is acted on is first moved a
little, by a draw of its own for each attempt; without it a deterministic simulator would repeat
itself.

A grasp at another body than the target is not measured: it is a wrong-object grasp, held or not.
Nor are views: a move that is planned free of collisions always arrives in the simulator. The
target is grasped after looks from all sides, and that outcome holds for everybody, however little
they looked: which grasp the robot finds depends on what it has seen, but an outcome must not.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from surefetch.common.cell import Cell, InformRow
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.common.parameters import FULL, Parameters
from surefetch.common.streams import stream
from surefetch.evaluation.policies.observation import Observation
from surefetch.evaluation.recordings.measured import FORMAT, MOST_ATTEMPTS, Attempt, Measured
from surefetch.evaluation.recordings.recording import Recording, RecordingTruth
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.episode import Errand, play
from surefetch.evaluation.replaying.live_world import perception_of
from surefetch.evaluation.replaying.nudged_world import GraspMeasured, Nudged, RemovalMeasured
from surefetch.evaluation.scenes.generate import GeneratedScene, generate
from surefetch.planner import profiles, situation
from surefetch.planner.search import solve

RULES: Final = replace(profiles.EXTENDED, tries=1, outlives_failure=False)
"""Every attempt is an episode of its own, over with the first failure."""


@dataclass(frozen=True, eq=False)
class Instructed:
    """What the truth says is to be done. No policy: it is told what lies under each detection."""

    target: str | None
    """None: nothing is to be grasped."""
    opens: bool
    """Whether the cover is to be removed."""
    bodies: Mapping[str, str | None]
    """Under each detection, as the looks tell it."""

    def act(self, now: Observation) -> Choice:
        """Remove the cover if it must be, look from all sides, then grasp the target."""
        row = next((row for row in now.informs if self._leads_there(row)), None)
        if row is not None:
            return Inform(name=row.name)
        last = {track.id: track.last_detection for track in now.believed.tracks}
        for grip in now.grasps:
            if self.target is not None and self.bodies.get(last[grip.track]) == self.target:
                return Grasp(track=grip.track, relation=grip.relation)
        return Defer()

    def _leads_there(self, row: InformRow) -> bool:
        if row.kind == "remove_cover":
            return self.opens
        return self.target is not None and not (self.opens and row.requires == "covered")


def measure(
    recording: Recording, truth: RecordingTruth, cell: Cell, numbers: Parameters
) -> Measured:
    """Attempts at a scene's cover and at its target, each until the first success.

    Args:
        recording: says what is asked for, and by which perception the scene is seen.
        truth: says what is to be done.
        cell: the robot's.
        numbers: with which looks are believed; no outcome depends on them but through the order
            in which two allowed relations of the target are tried.
    """
    site = Site(generate(recording.family, recording.seed), recording, cell, numbers)
    inside = truth.relation == "inside"
    removals = _attempts(site, RemovalMeasured, None, opens=True) if recording.covered else ()
    grasps = _attempts(site, GraspMeasured, truth.target, opens=inside) if truth.target else ()
    return Measured(
        format=FORMAT, family=truth.family, seed=truth.seed, removals=removals, grasps=grasps
    )


@dataclass(frozen=True, eq=False)
class Site:
    """Where a scene is measured."""

    made: GeneratedScene
    recording: Recording
    cell: Cell
    numbers: Parameters

    def table(self, kind: type[Nudged], attempt: int) -> Nudged:
        """A fresh one."""
        policy = profiles.Policy("instructed", RULES, solve)
        errand = situation.Errand(self.recording.target, "hold", policy, self.numbers, self.cell)
        return kind(self.made, errand, perception_of(self.recording.backend), attempt)

    def beliefs(self) -> Beliefs:
        """Before the first look."""
        asked, backend = self.recording.target.relation, self.recording.backend
        return Beliefs(asked, backend, self.numbers, FULL, self.numbers.q_hat())


def _attempts(
    site: Site, kind: type[Nudged], target: str | None, *, opens: bool
) -> tuple[Attempt, ...]:
    """Up to the first that succeeds; none where the robot sees no way to try."""
    attempts: list[Attempt] = []
    for n in range(1, MOST_ATTEMPTS + 1):
        made = _attempt(site, kind, target, n, opens=opens)
        attempts += made
        if not made or made[-1].done:
            break
    return tuple(attempts)


def _attempt(
    site: Site, kind: type[Nudged], target: str | None, n: int, *, opens: bool
) -> list[Attempt]:
    recording = site.recording
    errand = Errand(recording.target, site.cell, site.numbers, RULES)
    rng = stream(recording.family, recording.seed, "outcome", "instructed", n)
    with site.table(kind, n) as table:
        instructed = Instructed(target, opens, table.bodies)
        play(instructed, errand, table, site.beliefs(), rng)
        return table.attempts
