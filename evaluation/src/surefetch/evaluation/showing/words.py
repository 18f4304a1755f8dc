"""Hypotheses, choices and commands in the words that people read. Pure."""

from surefetch.common.hypotheses import ABS, UNOBS, parse_tracked
from surefetch.common.messages import (
    Choice,
    Defer,
    Deliver,
    Grasp,
    Inform,
    Look,
    QValue,
    Verb,
)


def hypothesis(name: str) -> str:
    """``"3:inside"`` as ``"T3 inside"``; `unobs` and `abs` as not seen yet and absent."""
    parsed = parse_tracked(name)
    if parsed is not None:
        return f"T{parsed[0]} {parsed[1]}"
    return {UNOBS: "not seen yet", ABS: "absent"}[name]


def choice(chosen: Choice | None) -> str:
    """What was decided."""
    if chosen is None:
        return "nothing is admissible"
    if isinstance(chosen, Inform):
        return chosen.name
    if isinstance(chosen, Defer):
        return "defer"
    return f"grasp T{chosen.track} ({chosen.relation})"


def verb(commanded: Verb) -> str:
    """What the arm was told to do."""
    if isinstance(commanded, Inform):
        return commanded.name
    if isinstance(commanded, Grasp):
        return f"grasp T{commanded.track}"
    if isinstance(commanded, Look):
        return f"look from {commanded.view}"
    if isinstance(commanded, Deliver):
        return f"deliver to {commanded.place}"
    return "put back"


def q_value(value: QValue) -> str:
    """One admissible action and its cost."""
    track = "" if value.track is None else f" T{value.track} {value.relation}"
    return f"{value.action}{track} {value.value:.3f}"


def ranked(belief: dict[str, float]) -> list[tuple[str, float]]:
    """Hypotheses from the most to the least probable; equal ones keep their order."""
    return sorted(belief.items(), key=lambda item: -item[1])
