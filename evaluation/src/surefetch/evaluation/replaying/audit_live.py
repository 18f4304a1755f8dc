"""Recorded scenes, run live from their seeds: by the four processes, or in this one."""

from surefetch.common.cell import Cell
from surefetch.common.injections import Injector
from surefetch.common.messages import Event, Instruct
from surefetch.common.policies import OWN_PROFILE
from surefetch.evaluation.replaying import audit
from surefetch.evaluation.replaying.audit import Course
from surefetch.evaluation.replaying.contenders import Contender, errand_of
from surefetch.evaluation.replaying.live_world import LiveWorld, perception_of
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.sitting import Sitting
from surefetch.evaluation.running.live import Live
from surefetch.evaluation.scenes.generate import generate


def has_processes(one: Contender) -> bool:
    """Whether the services know this policy; others are run in this process."""
    return one.name in OWN_PROFILE


def by_processes(live: Live, one: Contender, scene: RecordedScene) -> Course:
    """An episode of the four processes. Raises what `Live.run` raises."""
    recording = scene.recording
    made = generate(recording.family, recording.seed)
    asked = Instruct(
        sentence=recording.sentence,
        profile=one.profile.name,
        policy=one.name,
        after_grasp="hold",
    )
    finished = live.run(asked, made.scene, _show_nothing)
    return audit.of_live(finished.observed.events, finished.ended)


def in_process(one: Contender, scene: RecordedScene, cell: Cell) -> Course:
    """An episode on the simulated table, with this process in the place of the four."""
    recording = scene.recording
    made = generate(recording.family, recording.seed)
    with LiveWorld(
        made, errand_of(one, recording.target, cell), perception_of(recording.backend), Injector()
    ) as world:
        sitting = Sitting.begin(one, scene, cell)
        return audit.of_replay(sitting.play(world, sitting.beliefs()))


def _show_nothing(_: Event) -> None:
    """Many episodes are told in a line each."""
