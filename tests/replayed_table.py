"""Scripted tables, recorded and replayed by policies."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from recorded_table import numbers
from scripted_table import CELL, Table, thing, thing_inside

from surefetch.common.cell import InformRow
from surefetch.common.injections import Injector
from surefetch.common.messages import Choice, Defer, Inform, Injection
from surefetch.evaluation.policies.observation import Observation, Policy
from surefetch.evaluation.recordings.recording import Recording, RecordingTruth
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import contender
from surefetch.evaluation.replaying.episode import Errand, Played, play
from surefetch.evaluation.replaying.evaluate import Conditions, evaluate
from surefetch.evaluation.replaying.outcomes import Outcome, Rates
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import ready
from surefetch.planner.profiles import PROFILES

NEVER_FAILS = Conditions(rates=Rates(1.0, 1.0, 1.0))
UNREAD_FIRST = (thing(0.9, -0.1, center="unread"), thing(0.9, 0.1, "other", center="unread"))
TABLES = {
    "one is clear": Table((thing(0.9, -0.1), thing(0.9, 0.1, "other"))),
    "it must be looked at": Table(UNREAD_FIRST),
    "nothing fits": Table((thing(0.9, -0.1, "other"), thing(0.9, 0.1, "other"))),
    "two fit": Table((thing(0.9, -0.1), thing(0.9, 0.1))),
    "it is under the cover": Table((thing_inside(), thing(0.8, 0.2, "other")), covered=True),
    "nothing is there": Table(()),
}


@dataclass(frozen=True)
class ByScript:
    """Outcomes as a live table's script has them: by action, what becomes of each try."""

    fails: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def informs(self, row: InformRow, attempt: int) -> Outcome:
        return self._works(row.name, attempt)

    def grasps(self, body: str | None, attempt: int) -> Outcome:
        return self._works("grasp", attempt) if body is not None else Outcome(False)

    def _works(self, action: str, attempt: int) -> Outcome:
        script = self.fails.get(action, ())
        return Outcome(attempt > len(script) or script[attempt - 1] == "done")


def replayed(
    policy: Policy,
    recorded: tuple[Recording, RecordingTruth],
    profile: str = "extended",
    fails: Mapping[str, Sequence[str]] | None = None,
    injected: tuple[Injection, ...] = (),
) -> Played:
    """One episode under a profile, its actions as scripted or reported as failed."""
    recording, truth = recorded
    scene = ready(recording, truth)
    world = RecordedWorld(scene, ByScript(fails or {}), Injector(recording.family, 0, injected))
    parameters = numbers(profile)
    errand = Errand(recording.target, CELL, parameters, PROFILES[profile])
    beliefs = Beliefs(recording.target.relation, recording.backend, parameters, "full", 0.9)
    return play(policy, errand, world, beliefs, np.random.default_rng(0))


def evaluated(
    recorded: Sequence[tuple[Recording, RecordingTruth]],
    labels: Sequence[str],
    conditions: Conditions,
    profile: str = "extended",
) -> dict[str, list[EpisodeResult]]:
    """What `surefetch study evaluate` would write of these policies on these tables."""
    parameters = {name: numbers(name) for name in PROFILES}
    contenders = [contender(label, profile, parameters) for label in labels]
    played = [list(evaluate(ready(*one), contenders, CELL, conditions)) for one in recorded]
    return {label: [scene[n] for scene in played] for n, label in enumerate(labels)}


def names(taken: Sequence[Choice]) -> list[str]:
    """Everything but the defer, in words that every table has in common."""
    return [
        choice.name if isinstance(choice, Inform) else "grasp"
        for choice in taken
        if not isinstance(choice, Defer)
    ]


class Spy:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.told: list[Observation] = []

    def act(self, now: Observation) -> Choice:
        self.told.append(now)
        return Inform(name=now.informs[0].name) if now.informs else Defer()
