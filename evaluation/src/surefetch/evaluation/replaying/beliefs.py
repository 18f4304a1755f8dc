"""What is believed after a history of looks at one scene; equal histories, one belief."""

import hashlib
from dataclasses import dataclass, field
from typing import Final

import msgspec

from surefetch.belief.episode import EpisodeBelief
from surefetch.common import codec
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import BeliefReply, Observations, Update
from surefetch.common.parameters import Parameters
from surefetch.common.topics import UPDATE
from surefetch.evaluation.fitting.variants import believed, rules_for
from surefetch.evaluation.recordings.recording import State

EPISODE: Final = "replayed"
"""The same in all scenes: the reply, which the policy sees, must not say which scene it is."""
ANY_PROFILE: Final = "any"


@dataclass(frozen=True)
class Heard:
    """One look, as the belief takes it."""

    state: State
    q: str
    counted: bool
    covered: bool
    """As perception verified last, this look included."""
    take: int = 0
    """0: the one that was recorded; others are taken while an episode is finished live."""


History = tuple[Heard, ...]


@dataclass(frozen=True, eq=False)
class Belief:
    """What a history of looks leads to."""

    reply: BeliefReply
    delivered: str
    """Hash of what the belief was given by the last look, whoever's belief it is."""
    episode: EpisodeBelief


@dataclass(frozen=True, eq=False)
class Beliefs:
    """The beliefs of one scene by one variant. Histories are remembered: policies share them."""

    asked: AskedRelation
    backend: str
    parameters: Parameters
    variant: str
    q_hat: float
    _known: dict[History, Belief] = field(default_factory=dict)

    def after(self, history: History, seen: Observations) -> Belief:
        """Tracks, belief and Γ after at least one look.

        Args:
            history: all looks; all but the last were asked for before.
            seen: what the last one showed.
        """
        if history not in self._known:
            *before, last = history
            start = self._known[tuple(before)].episode if before else self._nothing()
            update = self._update(last, len(before), seen)
            episode, reply = believed(start, update, self.variant)
            self._known[history] = Belief(reply, _hash(update), episode)
        return self._known[history]

    def apart(self) -> "Beliefs":
        """The same so far; what is asked for from now on, the others do not learn."""
        return Beliefs(
            self.asked, self.backend, self.parameters, self.variant, self.q_hat, dict(self._known)
        )

    def _nothing(self) -> EpisodeBelief:
        return EpisodeBelief(rules_for(self.parameters, self.asked, self.variant, self.q_hat))

    def _update(self, heard: Heard, step: int, seen: Observations) -> Update:
        return Update(
            episode=EPISODE,
            step=step,
            obs_seq=step,
            profile=self.parameters.profile,
            backend=self.backend,
            q=heard.q,
            asked=self.asked,
            counted=heard.counted,
            detections=tuple(d for d in seen.detections if d.representative),
            covered=heard.covered,
        )


def _hash(update: Update) -> str:
    """Of everything that is delivered, but for what only names the numbers and counts the looks."""
    same = msgspec.structs.replace(update, profile=ANY_PROFILE, step=0, obs_seq=0)
    encoded = codec.encode(same, max_bytes=UPDATE.max_request_bytes)
    return hashlib.blake2b(encoded, digest_size=8).hexdigest()
