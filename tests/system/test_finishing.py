"""A live table goes as its recording went, and takes over where a recording is left."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import pytest

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import InfrastructureError
from surefetch.common.injections import Injector
from surefetch.common.messages import Grasp, Injection, Observations, Observe
from surefetch.common.parameters import PROFILES, profile_parameters
from surefetch.common.topics import OBSERVE
from surefetch.evaluation.recordings.measured import Attempt, Measured
from surefetch.evaluation.recordings.studio import Studio
from surefetch.evaluation.replaying import audit
from surefetch.evaluation.replaying.contenders import Contender, contender, errand_of
from surefetch.evaluation.replaying.episode import Played
from surefetch.evaluation.replaying.evaluate import Conditions, world_of
from surefetch.evaluation.replaying.finishing import finish
from surefetch.evaluation.replaying.live_world import LiveWorld
from surefetch.evaluation.replaying.scene import RecordedScene, ready
from surefetch.evaluation.replaying.sitting import Sitting
from surefetch.evaluation.scenes.generate import GeneratedScene, generate

pytestmark = pytest.mark.long
CELL = simulated_cell()
SLIPS = Attempt(done=False, why="slipped", moved_m=0.02, turned_deg=5.0, duration_s=9.0)
HOLDS = Attempt(done=True, why="", moved_m=0.0, turned_deg=0.0, duration_s=9.0)


@pytest.fixture(scope="module")
def made() -> GeneratedScene:
    return generate("covered", 1)


@pytest.fixture(scope="module")
def scene(made: GeneratedScene) -> RecordedScene:
    with Studio(made, CELL, "classical") as studio:
        made_of = studio.record()
    measured = Measured(
        format=1, family="covered", seed=1, removals=(HOLDS,), grasps=(SLIPS, HOLDS)
    )
    return ready(made_of.recording, made_of.truth, measured=measured)


def ours() -> Contender:
    numbers = {name: profile_parameters(name, None) for name in PROFILES}
    return contender("ours", "extended", numbers)


@contextmanager
def live(made: GeneratedScene, *injected: Injection) -> Iterator[LiveWorld]:
    errand = errand_of(ours(), made.target, CELL)
    with LiveWorld(made, errand, "classical", Injector("covered", 1, injected)) as world:
        yield world


def played(scene: RecordedScene, world: LiveWorld) -> Played:
    sitting = Sitting.begin(ours(), scene, CELL)
    return sitting.play(world, sitting.beliefs())


def test_a_live_table_goes_as_its_recording_went(
    made: GeneratedScene, scene: RecordedScene
) -> None:
    never_slips = replace(scene, measured=_holding(scene))
    sitting = Sitting.begin(ours(), never_slips, CELL)
    replayed = sitting.play(world_of(never_slips, Conditions("measured")), sitting.beliefs())
    with live(made) as world:
        found = audit.compare(audit.of_replay(replayed), audit.of_replay(played(scene, world)))
        target = world.simulated.held()
    assert (found.same_actions, found.same_outcome) == (True, True), found.why
    assert target == scene.truth.target


def _holding(scene: RecordedScene) -> Measured:
    assert scene.measured is not None
    return Measured(
        format=1, family="covered", seed=1, removals=scene.measured.removals, grasps=(HOLDS,)
    )


def test_an_injected_failure_leaves_a_live_table_as_it_was(
    made: GeneratedScene, scene: RecordedScene
) -> None:
    with live(made) as world:
        plain = played(scene, world).taken
    with live(made, Injection(kind="view", occurrence=1)) as world:
        struck = played(scene, world)
    failed = [m.report for m in struck.moments if m.report and not m.report.done]
    assert [r.injected for r in failed] == [True]
    assert struck.end.outcome == "grasped"
    assert len(struck.taken) == len(plain) + 1


def test_after_a_failure_that_moved_the_target_the_episode_goes_on_live(
    scene: RecordedScene,
) -> None:
    world = world_of(scene, Conditions("measured"))
    sitting = Sitting.begin(ours(), scene, CELL)
    beliefs = sitting.beliefs()
    left = sitting.play(world, beliefs)
    assert (left.end.outcome, left.end.reason) == ("aborted", "out_of_recording")
    whole, bodies = finish(sitting, left, world, beliefs)
    assert whole.taken[: len(left.taken)] == left.taken
    assert whole.end.outcome == "grasped"
    last = next(m for m in reversed(whole.moments) if m.report is not None)
    assert last.report is not None
    assert last.report.body == scene.truth.target
    tried = left.taken[-1]
    assert isinstance(tried, Grasp)
    before = next(t for t in left.moments[-1].believed.tracks if t.id == tried.track)
    after = next(t for t in whole.moments[-1].believed.tracks if t.id == before.id)
    assert after.center_world_m != before.center_world_m
    assert scene.truth.target in bodies.values()


def test_a_service_that_fails_ends_the_episode_as_aborted(
    made: GeneratedScene, scene: RecordedScene
) -> None:
    with live(made) as world:
        world._desk._answering[OBSERVE.name] = _fails
        end = played(scene, world).end
    assert (end.outcome, end.reason) == ("aborted", "infrastructure")


def _fails(_: Observe) -> Observations:
    raise InfrastructureError("the camera is gone")
