"""Policies on one recorded scene, scored. The truth goes to the world and the scorer alone."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from surefetch.common.cell import Cell
from surefetch.common.injections import Injector
from surefetch.common.messages import Injection
from surefetch.common.parameters import check_origin
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.oracle import play_oracle
from surefetch.evaluation.replaying.outcomes import Outcomes, Rates
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.scoring import score
from surefetch.evaluation.replaying.sitting import Sitting


@dataclass(frozen=True)
class Conditions:
    """What befalls every policy alike."""

    rates: Rates = Rates()
    draw: int = 0
    """Which of many independent draws of the outcomes."""
    injections: tuple[Injection, ...] = ()


def evaluate(
    scene: RecordedScene, contenders: Iterable[Contender], cell: Cell, conditions: Conditions
) -> Iterator[EpisodeResult]:
    """One episode of each contender, in their order.

    Raises:
        BadInput: the recording is of another cell or perception than the parameters, or a policy
            took an action that was not open.
    """
    known: dict[tuple[str, str], Beliefs] = {}
    for one in contenders:
        check_origin(one.parameters, cell=scene.recording.cell, backend=scene.recording.backend)
        world = world_of(scene, conditions)
        if one.entry is None:
            yield play_oracle(one, scene, world, cell)
            continue
        sitting = Sitting.begin(one, scene, cell)
        beliefs = known.setdefault((one.profile.name, one.variant), sitting.beliefs())
        played = sitting.play(world, beliefs)
        yield score(played, one, scene, scene.bodies, cell)


def world_of(scene: RecordedScene, conditions: Conditions) -> RecordedWorld:
    """The table of a scene at the beginning of an episode."""
    address = scene.recording.family, scene.recording.seed
    outcomes = Outcomes(*address, conditions.rates, conditions.draw)
    return RecordedWorld(scene, outcomes, Injector(*address, conditions.injections))
