"""The scorer's two questions to the simulated cell: put this scene there, and what is true.

Nothing else may ask: these answers never reach perception, belief, planner or motion planning.
"""

from surefetch.common.messages import AskTruth, Scene, SceneLoaded, Truth
from surefetch.executor.simulation.pybullet_cell import PybulletCell


class Simulation:
    """Handlers of `topics.LOAD_SCENE` and `topics.TRUTH`."""

    def __init__(self, simulated: PybulletCell) -> None:
        self._simulated = simulated

    def load_scene(self, scene: Scene) -> SceneLoaded:
        """Replace what is on the table; the arm starts at home."""
        shift_m = self._simulated.load(scene)
        return SceneLoaded(bodies=len(scene.bodies), largest_shift_m=shift_m)

    def truth(self, ask: AskTruth) -> Truth:
        """Where everything is. A frame's counter is the number of the camera's image, from 1."""
        simulated = self._simulated
        return Truth(
            bodies=simulated.world.bodies_now(),
            lid_position_world_m=simulated.world.lid_position_m(),
            touched=tuple(simulated.touched),
            held=simulated.held(),
            segmentation=None if ask.frame is None else simulated.segmentation(ask.frame.counter),
        )
