"""What an episode tells the world while it runs, and the records of it that its end carries."""

import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf
from typing import Final

import msgspec

from surefetch.common.bus import Bus
from surefetch.common.messages import (
    Acted,
    ActionRecord,
    BeliefReply,
    Believed,
    Decided,
    Deliver,
    Ended,
    EpisodeOutcome,
    Event,
    Grasp,
    Happening,
    Inform,
    Look,
    Observations,
    Outcome,
    Perceived,
    PutBack,
    StepRecord,
    TrackSummary,
    Verb,
)
from surefetch.common.topics import EVENTS

MOTION: Final = "motion"
"""Among the durations: the modelled time of the arm."""


@dataclass(frozen=True)
class End:
    """How an episode ended."""

    outcome: EpisodeOutcome
    reason: str
    because: str
    track: int | None = None
    relation: str | None = None
    delivered: bool | None = None


class Account:
    """Publishes the events of one episode, numbered without gaps, and remembers the rest."""

    def __init__(
        self, bus: Bus, episode: str, clock_s: Callable[[], float] = time.monotonic
    ) -> None:
        self.episode = episode
        self.step = 0
        """Of the turn under way."""
        self._bus = bus
        self._clock_s = clock_s
        self._seq = 0
        self._actions: list[ActionRecord] = []
        self._steps: list[StepRecord] = []
        self._q_hat = inf
        self._durations: defaultdict[str, float] = defaultdict(float)

    def tell(self, happening: Happening) -> None:
        """Publish the next event."""
        event = Event(episode=self.episode, seq=self._seq, step=self.step, happening=happening)
        self._seq += 1
        self._bus.publish(EVENTS, event)

    def perceived(self, seen: Observations) -> None:
        """A frame was perceived."""
        perceived = Perceived(
            frame=seen.frame,
            n_candidates=sum(d.representative for d in seen.detections),
            container=seen.container is not None,
            cover=seen.cover,
            duration_s=seen.duration_s,
        )
        self.tell(perceived)

    def believed(self, reply: BeliefReply, q: str) -> None:
        """The belief took a look; `q` is its verified viewing condition."""
        counted = tuple(f"{a.track} {a.y}" for a in reply.assigned if a.counted)
        tracks = tuple(
            TrackSummary(
                id=t.id, center_world_m=t.center_world_m, n_observations=t.n_observations, y0=t.y0
            )
            for t in reply.tracks
        )
        self._q_hat = reply.q_hat
        self._steps.append(
            StepRecord(
                q=q, observations=counted, belief=reply.belief, gamma=reply.gamma, q_values=()
            )
        )
        believed = Believed(
            q=q, belief=reply.belief, gamma=reply.gamma, tracks=tracks, counted=counted
        )
        self.tell(believed)

    def decided(self, decided: Decided) -> None:
        """A decision was taken on the latest belief."""
        self._steps[-1] = msgspec.structs.replace(self._steps[-1], q_values=decided.q_values)
        self.tell(decided)

    def acted(self, verb: Verb, outcome: Outcome) -> None:
        """A command ended."""
        action = action_name(verb)
        self._durations[MOTION] += outcome.duration_s
        self._actions.append(
            ActionRecord(action=action, status=outcome.status, duration_s=outcome.duration_s)
        )
        acted = Acted(
            cmd_id=outcome.cmd_id,
            action=action,
            status=outcome.status,
            why=outcome.why,
            duration_s=outcome.duration_s,
        )
        self.tell(acted)

    def ended(self, end: End) -> Ended:
        """The episode is over."""
        ended = Ended(
            outcome=end.outcome,
            reason=end.reason,
            because=end.because,
            track=end.track,
            relation=end.relation,
            delivered=end.delivered,
            actions=tuple(self._actions),
            steps=tuple(self._steps),
            q_hat=self._q_hat,
            durations=dict(self._durations),
        )
        self.tell(ended)
        return ended

    @contextmanager
    def timed(self, service: str) -> Iterator[Callable[[], float]]:
        """Book the time within on a service; what it gives tells the seconds so far."""
        began_s = self._clock_s()
        try:
            yield lambda: self._clock_s() - began_s
        finally:
            self._durations[service] += self._clock_s() - began_s


def action_name(verb: Verb) -> str:
    """What was done, for records: information actions by their own names."""
    match verb:
        case Inform(name=name):
            return name
        case Grasp():
            return "grasp"
        case Look():
            return "look"
        case Deliver():
            return "deliver"
        case PutBack():
            return "put_back"
