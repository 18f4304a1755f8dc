"""The simulated executor, with failures that are only reported. No hardware is ever wrapped so."""

from typing import Any, Final

from surefetch.common.cell import Cell
from surefetch.common.hosted import Handle
from surefetch.common.injections import Injector, kind_of
from surefetch.common.messages import Command, Outcome, Scene, SceneLoaded
from surefetch.common.topics import EXECUTE, EXECUTOR, LOAD_SCENE
from surefetch.executor.outcomes import Outcomes
from surefetch.executor.ports import Gripper
from surefetch.executor.service import ExecutorService

WHY: Final = "the failure was injected: nothing was tried"


class InjectedFailures:
    """An executor that now and then says of an attempt that it failed, and does not make it.

    Which attempts these are comes with the scene; until one is loaded, there are none.
    """

    name = EXECUTOR

    def __init__(self, executor: ExecutorService, gripper: Gripper, cell: Cell) -> None:
        self.backend: Final = executor.backend
        self._executor = executor
        self._gripper = gripper
        self._cell = cell
        self._injector = Injector()
        self._outcomes = Outcomes()
        """Of the failures that were injected; the executor keeps its own."""
        self._passed_on: set[str] = set()

    @property
    def doing(self) -> str:
        """What the executor does."""
        return self._executor.doing

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        """The executor's, two of them by way of this."""
        mine = (Handle(EXECUTE, self.execute), Handle(LOAD_SCENE, self.load_scene))
        theirs = {one.topic.name: one for one in self._executor.handles}
        return tuple((theirs | {one.topic.name: one for one in mine}).values())

    def load_scene(self, scene: Scene) -> SceneLoaded:
        """Put a scene on the table; its failures are counted from here."""
        self._injector = Injector(scene.family, scene.seed, scene.injected)
        return self._executor.load_scene(scene)

    def execute(self, command: Command) -> Outcome:
        """Carry out a command once, or say that it failed. See `ExecutorService.execute`."""
        known = self._outcomes.of(command)
        if known is not None:
            return known
        if self._strikes(command):
            outcome = self._failed(command)
            self._outcomes.keep(command, outcome)
            return outcome
        return self._executor.execute(command)

    def end(self) -> None:
        """The process ends."""
        self._executor.end()

    def _strikes(self, command: Command) -> bool:
        kind = kind_of(command.verb, self._cell)
        if kind is None or command.cmd_id in self._passed_on or self._executor.stopped:
            return False
        strikes = self._injector.strikes(kind)
        if not strikes:
            self._passed_on.add(command.cmd_id)
        return strikes

    def _failed(self, command: Command) -> Outcome:
        return Outcome(
            cmd_id=command.cmd_id,
            status="failed",
            refusal=None,
            why=WHY,
            checks={},
            gripper_width_m=self._gripper.width_m(),
            holding=False,
            duration_s=0.0,
            planning_s=0.0,
            motions=(),
        )
