"""Policies on one recorded scene, scored. The truth goes to the world and the scorer alone."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput
from surefetch.common.injections import Injector
from surefetch.common.messages import Injection
from surefetch.common.parameters import check_origin
from surefetch.common.streams import stream
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.episode import Errand, Played, play
from surefetch.evaluation.replaying.oracle import play_oracle
from surefetch.evaluation.replaying.outcomes import Outcomes, Rates
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.scoring import score
from surefetch.evaluation.replaying.world import World


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
        key = (one.profile.name, one.variant)
        if key not in known:
            known[key] = beliefs_of(one, scene)
        yield _episode(one, scene, known[key], cell, conditions)


def _episode(
    one: Contender, scene: RecordedScene, beliefs: Beliefs, cell: Cell, conditions: Conditions
) -> EpisodeResult:
    world = world_of(scene, conditions)
    if one.entry is None:
        return play_oracle(one, scene, world, cell)
    return score(play_one(one, scene, world, beliefs, cell), one, scene, scene.bodies, cell)


def world_of(scene: RecordedScene, conditions: Conditions) -> RecordedWorld:
    """The table of a scene at the beginning of an episode."""
    address = scene.recording.family, scene.recording.seed
    outcomes = Outcomes(*address, conditions.rates, conditions.draw)
    return RecordedWorld(scene, outcomes, Injector(*address, conditions.injections))


def beliefs_of(one: Contender, scene: RecordedScene) -> Beliefs:
    """What a contender believes of a scene, before its first look."""
    recording = scene.recording
    return Beliefs(
        recording.target.relation, recording.backend, one.parameters, one.variant, one.q_hat
    )


def play_one(
    one: Contender, scene: RecordedScene, world: World, beliefs: Beliefs, cell: Cell
) -> Played:
    """One episode of a contender on a table of this scene.

    Raises:
        BadInput: the policy took an action that was not open; names it and the scene.
    """
    recording = scene.recording
    assert one.entry is not None
    errand = Errand(recording.target, cell, one.parameters, one.profile)
    rng = stream(recording.family, recording.seed, "policy", one.name)
    try:
        return play(one.entry.make(), errand, world, beliefs, rng)
    except BadInput as error:
        where = f"{recording.family}:{recording.seed}"
        raise BadInput(f'policy "{one.label}" on {where}: {error}') from None
