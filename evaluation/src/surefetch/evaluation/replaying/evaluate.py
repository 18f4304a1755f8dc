"""Policies on recorded scenes, scored. The truth goes to the world and the scorer alone."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.common.parameters import Parameters, check_origin
from surefetch.common.policies import OWN_PROFILE
from surefetch.common.streams import stream
from surefetch.evaluation.policies import registry
from surefetch.evaluation.policies.registry import Entry
from surefetch.evaluation.recordings.recording import Recording, RecordingTruth
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.episode import Errand, Played, play
from surefetch.evaluation.replaying.oracle import play_oracle
from surefetch.evaluation.replaying.outcomes import Outcomes, Rates
from surefetch.evaluation.replaying.scene import RecordedScene, ready
from surefetch.evaluation.replaying.world import OutOfRecording, RecordedWorld
from surefetch.evaluation.running.metrics import Scored, verdict
from surefetch.planner.actions import Costs
from surefetch.planner.profiles import PROFILES, Profile


@dataclass(frozen=True, eq=False)
class Contender:
    """A policy with the profile and the numbers that it plays by."""

    name: str
    entry: Entry | None
    """None: the oracle."""
    profile: Profile
    parameters: Parameters
    q_hat: float


@dataclass(frozen=True)
class Results:
    """Every policy's episodes, in the order of the scenes."""

    scored: Mapping[str, list[Scored]]
    left_recording: Mapping[str, list[str]] = field(default_factory=dict)
    """By policy, what could not be replayed and why; counted as aborted."""


def contender(name: str, profile: str, parameters: Mapping[str, Parameters]) -> Contender:
    """A policy by name; those with a profile of their own keep it.

    Raises:
        BadInput: there is no such policy, or its belief was not calibrated.
    """
    own = OWN_PROFILE.get(name, profile)
    numbers = parameters[own]
    if name == registry.ORACLE:
        return Contender(name, None, PROFILES[own], numbers, numbers.q_hat())
    entry = registry.find(name)
    return Contender(name, entry, PROFILES[own], numbers, numbers.q_hat(entry.variant))


def evaluate(
    scenes: Iterable[tuple[Recording, RecordingTruth]],
    contenders: Iterable[Contender],
    cell: Cell,
    rates: Rates,
) -> Results:
    """Every contender on every scene.

    Raises:
        BadInput: a recording is of another cell or perception than the parameters, or a policy
            took an action that was not open.
    """
    contenders = tuple(contenders)
    scored: dict[str, list[Scored]] = {c.name: [] for c in contenders}
    left: dict[str, list[str]] = {c.name: [] for c in contenders}
    for recording, truth in scenes:
        scene = ready(recording, truth)
        beliefs: dict[tuple[str, str], Beliefs] = {}
        for one in contenders:
            try:
                scored[one.name].append(_episode(one, scene, beliefs, cell, rates))
            except OutOfRecording as error:
                left[one.name].append(str(error))
                aborted = Scored(recording.family, recording.seed, "aborted", 0, 0.0)
                scored[one.name].append(aborted)
    return Results(scored, left)


def _episode(
    one: Contender,
    scene: RecordedScene,
    beliefs: dict[tuple[str, str], Beliefs],
    cell: Cell,
    rates: Rates,
) -> Scored:
    recording = scene.recording
    check_origin(one.parameters, cell=recording.cell, backend=recording.backend)
    outcomes = Outcomes(recording.family, recording.seed, rates)
    if one.entry is None:
        return play_oracle(scene.truth, recording.covered, one.profile, outcomes, cell)
    key = (one.profile.name, one.entry.variant)
    if key not in beliefs:
        beliefs[key] = Beliefs(
            scene.shots, recording.target.relation, recording.backend, one.parameters,
            one.entry.variant, one.q_hat,
        )  # fmt: skip
    errand = Errand(recording.target, cell, one.parameters, one.profile)
    world = RecordedWorld(scene, outcomes)
    rng = stream(recording.family, recording.seed, "policy", one.name)
    try:
        played = play(one.entry.make(), errand, world, beliefs[key], rng)
    except BadInput as error:
        where = f"{recording.family}:{recording.seed}"
        raise BadInput(f'policy "{one.name}" on {where}: {error}') from None
    return score(played, scene, world.grasped_at, cell)


def score(played: Played, scene: RecordedScene, grasped_at: list[str], cell: Cell) -> Scored:
    """How the tables count an episode."""
    found = verdict(
        played.end.outcome,
        played.end.reason,
        target=scene.truth.target,
        grasped=grasped_at,
        anything_seen=played.n_tracks > 0,
    )
    moved = [choice for choice in played.taken if not isinstance(choice, Defer)]
    cost = sum(cost_of(choice, cell) for choice in moved)
    recording = scene.recording
    return Scored(recording.family, recording.seed, found, len(moved), cost)


def cost_of(choice: Choice, cell: Cell) -> float:
    """The planner's constant of one action."""
    match choice:
        case Inform(name=name):
            return cell.inform(name).cost
        case Grasp():
            return Costs().grasp
        case Defer():
            return 0.0
