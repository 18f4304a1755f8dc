"""What `surefetch run` prints as JSON and leaves as summary.json. Pure."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal

import msgspec

from surefetch.common.messages import Accepted, ActionRecord, Ended, Message, Status, StepRecord
from surefetch.evaluation.running.scoring import Score

FORMAT: Final = 1
CutShort = Literal["aborted", "stopped"]
EXIT_CODES: Final[dict[str, int]] = {
    "grasped": 0,
    "deferred": 0,
    "failed": 1,
    "stalled": 1,
    "stopped": 1,
    "aborted": 3,
}


def summarize(
    *,
    scene: str,
    instruction: str,
    profile: str,
    policy: str,
    accepted: Accepted | None,
    ended: Ended,
    score: Score,
    wall_s: float,
    services: Mapping[str, Status],
    missing: Sequence[str],
) -> dict[str, Any]:
    """The JSON of one episode; its keys and spellings are promised to programs."""
    return {
        "format": FORMAT,
        "episode": accepted.episode if accepted else None,
        "scene": scene,
        "instruction": instruction,
        "understood": accepted.understood if accepted else None,
        "profile": profile,
        "policy": policy,
        "outcome": ended.outcome,
        "reason": ended.reason,
        "because": ended.because,
        "correct": score.correct,
        "verdict": score.verdict,
        "delivered": ended.delivered,
        "track": ended.track,
        "relation": ended.relation,
        "actions": actions(ended),
        "steps": [_step(step) for step in ended.steps],
        "q_hat": _number(ended.q_hat),
        "durations": {**ended.durations, "total": wall_s},
        "services": {
            name: {"pid": status.pid, "host": status.host} for name, status in services.items()
        },
        "missing": list(missing),
    }


def cut_short(
    outcome: CutShort,
    reason: str,
    because: str,
    looks: Sequence[StepRecord] = (),
    actions: Sequence[ActionRecord] = (),
) -> Ended:
    """The end of an episode that its planner could not tell, with what was seen of it."""
    return Ended(
        outcome=outcome,
        reason=reason,
        because=because,
        track=None,
        relation=None,
        delivered=None,
        actions=tuple(actions),
        steps=tuple(looks),
        q_hat=math.inf,
        durations={},
    )


def actions(ended: Ended) -> list[dict[str, Any]]:
    """What the arm did, in plain values."""
    return [_untagged(action) for action in ended.actions]


def exit_code(outcome: str) -> int:
    """The exit code comes from the outcome, never from the truth."""
    return EXIT_CODES[outcome]


def _step(step: StepRecord) -> dict[str, Any]:
    return _untagged(step) | {"q_values": [_untagged(value) for value in step.q_values]}


def _untagged(message: Message) -> dict[str, Any]:
    """Plain values; a message's tag is the wire's affair."""
    plain: dict[str, Any] = msgspec.to_builtins(message)
    del plain["type"]
    return plain


def _number(value: float) -> float | str:
    return "inf" if math.isinf(value) else value
