"""What is believed after a history of looks at one recorded scene; equal histories, one belief."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from surefetch.belief.episode import EpisodeBelief
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import BeliefReply, Observations, Update
from surefetch.common.parameters import Parameters
from surefetch.evaluation.fitting.variants import believed, rules_for
from surefetch.evaluation.recordings.recording import State

EPISODE: Final = "replayed"
"""The same in all scenes: the reply, which the policy sees, must not say which scene it is."""


@dataclass(frozen=True)
class Heard:
    """One look, as the belief takes it."""

    state: State
    q: str
    counted: bool
    covered: bool
    """As perception verified last, this look included."""


History = tuple[Heard, ...]


@dataclass(frozen=True, eq=False)
class Beliefs:
    """The beliefs of one scene by one variant. Histories are remembered: policies share them."""

    shots: Mapping[State, Observations]
    asked: AskedRelation
    backend: str
    parameters: Parameters
    variant: str
    q_hat: float
    _known: dict[History, tuple[EpisodeBelief, BeliefReply]] = field(default_factory=dict)

    def after(self, history: History) -> BeliefReply:
        """Tracks, belief and Γ after at least one look."""
        return self._step(history)[1]

    def _step(self, history: History) -> tuple[EpisodeBelief, BeliefReply]:
        if history not in self._known:
            *before, last = history
            start = self._step(tuple(before))[0] if before else self._nothing()
            update = self._update(last, len(before))
            self._known[history] = believed(start, update, self.variant)
        return self._known[history]

    def _nothing(self) -> EpisodeBelief:
        return EpisodeBelief(rules_for(self.parameters, self.asked, self.variant, self.q_hat))

    def _update(self, heard: Heard, step: int) -> Update:
        detections = self.shots[heard.state].detections
        return Update(
            episode=EPISODE,
            step=step,
            obs_seq=step,
            profile=self.parameters.profile,
            backend=self.backend,
            q=heard.q,
            asked=self.asked,
            counted=heard.counted,
            detections=tuple(d for d in detections if d.representative),
            covered=heard.covered,
        )
