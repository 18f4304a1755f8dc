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
from surefetch.evaluation.replaying.episode import Errand, play
from surefetch.evaluation.replaying.oracle import play_oracle
from surefetch.evaluation.replaying.outcomes import Outcomes, Rates
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.scoring import score


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
            known[key] = _beliefs(one, scene)
        yield _episode(one, scene, known[key], cell, conditions)


def _beliefs(one: Contender, scene: RecordedScene) -> Beliefs:
    recording = scene.recording
    return Beliefs(
        recording.target.relation, recording.backend, one.parameters, one.variant, one.q_hat
    )


def _episode(
    one: Contender, scene: RecordedScene, beliefs: Beliefs, cell: Cell, conditions: Conditions
) -> EpisodeResult:
    recording = scene.recording
    address = recording.family, recording.seed
    world = RecordedWorld(
        scene,
        Outcomes(*address, conditions.rates, conditions.draw),
        Injector(*address, conditions.injections),
    )
    if one.entry is None:
        return play_oracle(one, scene, world, cell)
    errand = Errand(recording.target, cell, one.parameters, one.profile)
    rng = stream(*address, "policy", one.name)
    try:
        played = play(one.entry.make(), errand, world, beliefs, rng)
    except BadInput as error:
        where = f"{recording.family}:{recording.seed}"
        raise BadInput(f'policy "{one.label}" on {where}: {error}') from None
    return score(played, one, scene, scene.bodies, cell)
