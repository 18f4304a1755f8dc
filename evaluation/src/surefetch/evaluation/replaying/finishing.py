"""Episodes that leave their recording are finished in the simulator, from the scene's seed.

The table is brought to where the recording was left: the cover off if it was removed, and where a
failed attempt moved bodies, the body that was acted on as far from its place as was measured, in a
direction that is drawn for this attempt. So the failure that was recorded counts, and the table
after it is the same for everybody. That is simpler than what fingers do: the other bodies stay,
and one that fell over stands.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import errand_of
from surefetch.evaluation.replaying.episode import Played
from surefetch.evaluation.replaying.live_world import perception_of
from surefetch.evaluation.replaying.nudged_world import Nudged
from surefetch.evaluation.replaying.outcomes import NO_BODY
from surefetch.evaluation.replaying.recorded_world import Disturbed, RecordedWorld
from surefetch.evaluation.replaying.sitting import Sitting
from surefetch.evaluation.scenes.generate import GeneratedScene, generate
from surefetch.executor.simulation import scene_bodies
from surefetch.executor.simulation.pybullet_world import STEP_S
from surefetch.planner import situation

TRIES: Final = 32
"""Directions that are tried; where none has room, the body stays."""
SETTLE_S: Final = 0.5


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
    with Table(made, errand, perception_of(recording.backend), world) as table:
        played = sitting.play(table, beliefs.apart(), left.turn)
        return played, table.bodies


class Table(Nudged):
    """A live table as a recorded one is left."""

    def __init__(
        self,
        made: GeneratedScene,
        errand: situation.Errand,
        perception: str,
        left: RecordedWorld,
    ) -> None:
        super().__init__(made, errand, perception, 0 if left.disturbed is None else
                         left.disturbed.attempt)  # fmt: skip
        self._injector = left.injector
        self.bodies |= left.bodies
        if left.cover == "open":
            self.lift_lid()
        if left.disturbed is not None:
            self._disturb(left.disturbed)

    def _disturb(self, by: Disturbed) -> None:
        """Move what was acted on as far as was measured, where there is room."""
        name = scene_bodies.LID if by.body == NO_BODY else by.body
        far_m, turned_deg = by.measured.moved_m, by.measured.turned_deg
        for angle_rad in self._dice.uniform(0.0, 2.0 * np.pi, TRIES):
            towards = (far_m * float(np.cos(angle_rad)), far_m * float(np.sin(angle_rad)))
            if self.shift(name, towards, turned_deg):
                break
        self.simulated.world.step(round(SETTLE_S / STEP_S))
