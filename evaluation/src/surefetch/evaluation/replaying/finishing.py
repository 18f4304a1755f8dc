"""Episodes that leave their recording are finished in the simulator, from the scene's seed.

The table is brought to where the recording was left: the cover off if it was removed, and what
failed is tried once more by the robot, at a body nudged as it was when the attempt was measured.
Should it succeed this time, it is undone: the outcome that was measured is the one that counts.
"""

from collections.abc import Mapping

from surefetch.common.messages import Grasp, Inform, PutBack
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import errand_of
from surefetch.evaluation.replaying.episode import Played
from surefetch.evaluation.replaying.live_world import perception_of
from surefetch.evaluation.replaying.nudged_world import Nudged
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.sitting import Sitting
from surefetch.evaluation.scenes.generate import generate
from surefetch.executor.simulation import scene_bodies
from surefetch.planner.episode_state import EpisodeState


def finish(
    sitting: Sitting, left: Played, world: RecordedWorld, beliefs: Beliefs
) -> tuple[Played, Mapping[str, str | None]]:
    """Go on where the recording was left.

    Args:
        sitting: policy and random numbers, as they are now.
        left: the episode up to there.
        world: the recording that was left.
        beliefs: that the episode had; what it believes from now on stays its own.

    Returns:
        The whole episode, and the body under each detection of all its looks.
    """
    recording = sitting.scene.recording
    made = generate(recording.family, recording.seed)
    errand = errand_of(sitting.one, recording.target, sitting.errand.cell)
    attempt = 1 if world.disturbed is None else world.disturbed.attempt
    with Table(made, errand, perception_of(recording.backend), attempt) as table:
        table.bring_to(left, world)
        played = sitting.play(table, beliefs.apart(), left.turn)
        return played, table.bodies


class Table(Nudged):
    """A live table to which an episode comes from a recording."""

    def bring_to(self, left: Played, world: RecordedWorld) -> None:
        """Make it as it was when the recording was left."""
        self._injector = world.injector
        self.bodies |= world.bodies
        if world.cover == "open":
            self.take_lid_away()
        state, choice = left.turn.state, left.moments[-1].choice
        if world.disturbed is None:
            return
        self._estimate = state.estimate
        self._drive(left.moments[-1].heard.state.view)
        if isinstance(choice, Grasp):
            self._fail_to_grasp(choice, world.disturbed.body, state)
        elif isinstance(choice, Inform):
            self._fail_to_remove(choice)

    def _fail_to_grasp(self, grasp: Grasp, body: str, state: EpisodeState) -> None:
        self.nudge(body)
        if self.try_grasp(grasp, state).done:
            self._crew.execute(PutBack(), state.estimate)

    def _fail_to_remove(self, inform: Inform) -> None:
        self.nudge(scene_bodies.LID)
        T_world_lid = self.simulated.world.pose(scene_bodies.LID)
        if self.try_inform(self._errand.cell.inform(inform.name)).done:
            self.simulated.world.put(scene_bodies.LID, T_world_lid)
        self._at_view = False
