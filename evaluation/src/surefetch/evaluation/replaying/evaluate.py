"""Policies on one recorded scene, scored. The truth goes to the world and the scorer alone."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

from surefetch.common.cell import Cell
from surefetch.common.injections import Injector
from surefetch.common.messages import Injection
from surefetch.common.parameters import check_origin
from surefetch.evaluation.policies import registry
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.episode import OUT_OF_RECORDING, Played
from surefetch.evaluation.replaying.hindsight import all_ways, best_way
from surefetch.evaluation.replaying.oracle import play_oracle
from surefetch.evaluation.replaying.outcomes import AsMeasured, Drawn, Mode, Outcomes, Rates
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.scoring import score
from surefetch.evaluation.replaying.sitting import Sitting


@dataclass(frozen=True)
class Conditions:
    """What befalls every policy alike."""

    mode: Mode = "bernoulli"
    rates: Rates = Rates()
    """Of what is drawn: everything, or with measured outcomes grasps of wrong bodies."""
    draw: int = 0
    """Which of many independent draws of the outcomes."""
    injections: tuple[Injection, ...] = ()


Finish = Callable[
    [Sitting, Played, RecordedWorld, Beliefs], tuple[Played, Mapping[str, str | None]]
]
"""See `finishing.finish`."""


def evaluate(
    scene: RecordedScene,
    contenders: Iterable[Contender],
    cell: Cell,
    conditions: Conditions,
    finish: Finish | None = None,
) -> Iterator[EpisodeResult]:
    """One episode of each contender, in their order.

    Args:
        scene: the recording.
        contenders: who plays.
        cell: the robot's.
        conditions: the same for all.
        finish: ends episodes that leave the recording; None: they count as aborted.

    Raises:
        BadInput: the recording is of another cell or perception than the parameters, or a policy
            took an action that was not open.
    """
    known: dict[tuple[str, str], Beliefs] = {}
    for one in contenders:
        check_origin(one.parameters, cell=scene.recording.cell, backend=scene.recording.backend)
        world = world_of(scene, conditions, remembers=one.remembers)
        if one.entry is None and one.name == registry.HINDSIGHT:
            again = partial(evaluate, scene, cell=cell, conditions=conditions)
            ways = all_ways(one, covered=scene.recording.covered, cell=cell)
            yield best_way(ways, again, partial(again, finish=finish))
            continue
        if one.entry is None:
            yield play_oracle(one, scene, world, cell)
            continue
        sitting = Sitting.begin(one, scene, cell)
        beliefs = known.setdefault((one.profile.name, one.variant), sitting.beliefs())
        played, bodies = sitting.play(world, beliefs), scene.bodies
        left = played.end.reason == OUT_OF_RECORDING
        if left and finish is not None:
            played, bodies = finish(sitting, played, world, beliefs)
        yield score(played, one, scene, bodies, cell, finished_live=left and finish is not None)


def world_of(
    scene: RecordedScene, conditions: Conditions, *, remembers: bool = True
) -> RecordedWorld:
    """The table of a scene at the beginning of an episode. See `RecordedWorld`."""
    address = scene.recording.family, scene.recording.seed
    outcomes: Outcomes
    outcomes = drawn = Drawn(*address, conditions.rates, conditions.draw)
    if conditions.mode == "measured":
        assert scene.measured is not None
        outcomes = AsMeasured(scene.measured, scene.truth.target, drawn)
    injector = Injector(*address, conditions.injections)
    return RecordedWorld(scene, outcomes, injector, remembers=remembers)
