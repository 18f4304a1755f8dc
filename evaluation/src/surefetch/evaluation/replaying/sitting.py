"""One contender at one scene: its policy and its random numbers last for the whole episode."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput
from surefetch.common.streams import stream
from surefetch.evaluation.policies.observation import Policy
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.episode import Errand, Played, Turn, play
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.world import World


@dataclass(frozen=True, eq=False)
class Sitting:
    """A policy that was made for this episode."""

    one: Contender
    scene: RecordedScene
    errand: Errand
    policy: Policy
    rng: np.random.Generator

    @classmethod
    def begin(cls, one: Contender, scene: RecordedScene, cell: Cell) -> Self:
        """Before the first look. Not for the oracle, which is no policy."""
        assert one.entry is not None
        recording = scene.recording
        return cls(
            one=one,
            scene=scene,
            errand=Errand(recording.target, cell, one.parameters, one.profile),
            policy=one.entry.make(),
            rng=stream(recording.family, recording.seed, "policy", one.name),
        )

    def beliefs(self) -> Beliefs:
        """What is believed of the scene, before the first look."""
        one, recording = self.one, self.scene.recording
        return Beliefs(
            recording.target.relation, recording.backend, one.parameters, one.variant, one.q_hat
        )

    def play(self, world: World, beliefs: Beliefs, turn: Turn | None = None) -> Played:
        """The episode to its end, from the beginning or from where another world was left.

        Raises:
            BadInput: the policy took an action that was not open; names it and the scene.
        """
        try:
            return play(self.policy, self.errand, world, beliefs, self.rng, turn)
        except BadInput as error:
            recording = self.scene.recording
            where = f"{recording.family}:{recording.seed}"
            raise BadInput(f'policy "{self.one.label}" on {where}: {error}') from None
