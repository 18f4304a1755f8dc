"""The other three services, as an episode asks them."""

from collections.abc import Callable
from typing import Final, TypeVar

from surefetch.common.bus import Bus
from surefetch.common.errors import InfrastructureError
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import (
    Acting,
    AskFeasible,
    BeliefReply,
    Capture,
    Captured,
    Command,
    Estimate,
    Feasibility,
    FrameInfo,
    Message,
    Observations,
    Observe,
    Outcome,
    Target,
    Update,
    Verb,
)
from surefetch.common.topics import CAPTURE, EXECUTE, FEASIBLE, OBSERVE, UPDATE, Topic
from surefetch.planner.account import Account

Q = TypeVar("Q", bound=Message)
R = TypeVar("R", bound=Message)

PATIENCE_S: Final = {
    CAPTURE.name: 60.0,
    OBSERVE.name: 120.0,
    UPDATE.name: 30.0,
    FEASIBLE.name: 180.0,
    EXECUTE.name: 600.0,
}
"""How long an answer may take on a loaded machine. A dead service is noticed at once all the same,
and so is a stopped robot."""


class Stopped(Exception):  # noqa: N818
    """The operator ended the episode, at the robot or by cancelling it."""


class Crew:
    """Asks one thing after the other; everything asked and answered goes into the account."""

    def __init__(
        self,
        bus: Bus,
        account: Account,
        *,
        new_id: Callable[[], str],
        cancelled: Callable[[], bool],
    ) -> None:
        """Speak for one episode; `new_id` gives each command its identity."""
        self._bus = bus
        self._account = account
        self._new_id = new_id
        self._cancelled = cancelled
        self.doing = "begins"

    def capture(self) -> FrameInfo:
        """A fresh frame from where the arm stands."""
        return self._ask(CAPTURE, Capture(episode=self._account.episode, step=self._account.step))

    def observe(self, frame: FrameInfo, target: Target, q: str) -> Observations:
        """What perception says of a frame; `q` is what the look is expected to be."""
        self._account.tell(Captured(frame=frame.frame, view=frame.view, q=q))
        request = Observe(
            episode=self._account.episode,
            step=self._account.step,
            frame=frame.frame,
            target=target,
        )
        seen = self._ask(OBSERVE, request)
        if seen.frame != frame.frame:
            raise InfrastructureError("perception answered for another frame than it was asked.")
        self._account.perceived(seen)
        return seen

    def believe(
        self,
        seen: Observations,
        *,
        q: str,
        asked: AskedRelation,
        counted: bool,
        covered: bool,
        profile: str,
    ) -> BeliefReply:
        """The belief after a look; `asked` is the relation that the target is to have."""
        update = Update(
            episode=self._account.episode,
            step=self._account.step,
            obs_seq=self._account.step,
            profile=profile,
            backend=seen.backend,
            q=q,
            asked=asked,
            counted=counted,
            detections=tuple(d for d in seen.detections if d.representative),
            covered=covered,
        )
        reply = self._ask(UPDATE, update)
        self._account.believed(reply, q)
        return reply

    def feasible(
        self, estimate: Estimate, grasps: tuple[int, ...], informs: tuple[str, ...]
    ) -> Feasibility:
        """Which of these the robot could do now."""
        if not grasps and not informs:
            return Feasibility(grasps=(), informs=(), duration_s=0.0)
        request = AskFeasible(
            episode=self._account.episode,
            step=self._account.step,
            estimate=estimate,
            grasps=grasps,
            informs=informs,
        )
        return self._ask(FEASIBLE, request)

    def execute(self, verb: Verb, estimate: Estimate) -> Outcome:
        """Do this, once.

        Raises:
            Stopped: the robot was stopped, or the episode is cancelled.
        """
        cmd_id = self._new_id()
        self._account.tell(Acting(cmd_id=cmd_id, verb=verb))
        command = Command(
            cmd_id=cmd_id,
            episode=self._account.episode,
            step=self._account.step,
            verb=verb,
            estimate=estimate,
        )
        outcome = self._ask(EXECUTE, command)
        if outcome.cmd_id != cmd_id:
            raise InfrastructureError("executor answered for another command than it was given.")
        self._account.acted(verb, outcome)
        if outcome.status == "stopped":
            raise Stopped(outcome.why or "the robot was stopped")
        return outcome

    def _ask(self, topic: Topic[Q, R], request: Q) -> R:
        if self._cancelled():
            raise Stopped("the episode was cancelled")
        self.doing = f"step {self._account.step}: asks {topic.name}"
        with self._account.timed(topic.service):
            return self._bus.ask(topic, request, timeout_s=PATIENCE_S[topic.name])
