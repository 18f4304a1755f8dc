"""A decision in one plain sentence: what decided, the rivals, what could not be seen. Pure."""

from collections.abc import Iterable, Sequence

from surefetch.common.hypotheses import ABS, UNOBS, parse_tracked
from surefetch.common.messages import QValue
from surefetch.planner.problem import Solution
from surefetch.planner.situation import Errand, Situation


def sentence(errand: Errand, now: Situation, solution: Solution) -> str:
    """Why this action and no other."""
    chosen = solution.chosen
    if chosen is None:
        return f"Nothing can be done: {_and(_open_questions(errand, now, solution))}."
    if chosen.track is not None:
        return (
            f"T{chosen.track} {chosen.relation} is the only hypothesis left that the instruction "
            f"allows ({_p(now, f'{chosen.track}:{chosen.relation}')}), and the robot can grasp it."
        )
    if chosen.action != "defer":
        return _looking(errand, now, solution, chosen)
    if solution.gamma == (ABS,):
        return f"The object is not there: absent is the only hypothesis left ({_p(now, ABS)})."
    reasons = [*_open_questions(errand, now, solution), *_unseen(errand, now)]
    return f"There is nothing left to look at, and it is not sure enough: {_and(reasons)}."


def name(hypothesis: str) -> str:
    """A hypothesis as people read it: "T3 inside", "not seen yet", "absent"."""
    parsed = parse_tracked(hypothesis)
    if parsed is not None:
        return f"T{parsed[0]} {parsed[1]}"
    return {UNOBS: "not seen yet", ABS: "absent"}[hypothesis]


def _looking(errand: Errand, now: Situation, solution: Solution, chosen: QValue) -> str:
    why = _and(_open_questions(errand, now, solution))
    return f"It is not sure enough yet: {why}; {chosen.action} costs least ({chosen.value:.3f})."


def _open_questions(errand: Errand, now: Situation, solution: Solution) -> list[str]:
    """What keeps the robot from grasping."""
    allowed = [z for z in solution.gamma if _is_allowed(errand, z)]
    if len(allowed) > 1:
        rivals = [f"{name(z)} ({_p(now, z)})" for z in allowed]
        return [f"{_and(rivals)} are still rivals", *_beside(now, solution)]
    if allowed:
        return [_held_back(errand, now, solution, allowed[0]), *_beside(now, solution)]
    if not now.believed.tracks:
        return ["nothing was detected", *_beside(now, solution)]
    ruled_out = [z for z in solution.gamma if parse_tracked(z) is not None]
    if ruled_out:
        likely = [f"{name(z)} ({_p(now, z)})" for z in ruled_out]
        asked = f"{errand.target.relation} the {errand.target.container}"
        return [f"{_and(likely)} is likely, but {asked} was asked for", *_beside(now, solution)]
    return ["no object seen so far is likely enough", *_beside(now, solution)]


def _beside(now: Situation, solution: Solution) -> Iterable[str]:
    """The hypotheses without a track that are not ruled out."""
    if UNOBS in solution.gamma:
        yield f"the object may not have been seen yet ({_p(now, UNOBS)})"
    if ABS in solution.gamma:
        yield f"it may be absent ({_p(now, ABS)})"


def _held_back(errand: Errand, now: Situation, solution: Solution, hypothesis: str) -> str:
    """Why the one hypothesis that is left is not grasped."""
    track, _ = parse_tracked(hypothesis) or (0, "")
    verdict = next((v for v in now.feasibility.grasps if v.track == track), None)
    cost = next((q.value for q in solution.q_values if q.track == track), None)
    told = f"{name(hypothesis)} is the only one left that could be grasped ({_p(now, hypothesis)})"
    if cost is not None:
        return f"{told}, at a cost of {cost:.3f}"
    if verdict is not None and not verdict.feasible:
        return f"{told}, but it cannot be: {verdict.refusal}, {verdict.why}".rstrip(", ")
    if verdict is None and now.cover == "covered":
        return f"{told}, but the {errand.target.container} is covered"
    if now.believed.belief[hypothesis] < (least := errand.parameters.commit_at_least):
        return f"{told}, but a grasp takes a belief of {least:.3f}"
    return f"{told}, but it is not the likelier place of its track, or other tracks are likelier"


def _unseen(errand: Errand, now: Situation) -> Iterable[str]:
    """What could not be seen."""
    tracks = now.believed.tracks
    unread = [f"T{t.id}" for t in tracks if t.y0 is None or t.y0.startswith("U")]
    if unread:
        yield f"{_and(unread)} could not be read for sure"
    unplaced = [f"T{t.id}" for t in tracks if t.y0 == "MU"]
    if unplaced:
        yield f"where {_and(unplaced)} stands could not be seen"
    if now.cover == "covered":
        yield f"the {errand.target.container} stays covered"
    for verdict in now.feasibility.informs:
        if not verdict.feasible:
            yield f"{verdict.name} is out of the robot's power ({verdict.refusal})"


def _is_allowed(errand: Errand, hypothesis: str) -> bool:
    parsed = parse_tracked(hypothesis)
    return parsed is not None and errand.target.relation in ("any", parsed[1])


def _p(now: Situation, hypothesis: str) -> str:
    return f"{now.believed.belief[hypothesis]:.3f}"


def _and(parts: Sequence[str]) -> str:
    """As people list things: "a, b and c"."""
    if len(parts) < 2:
        return "".join(parts)
    return f"{', '.join(parts[:-1])} and {parts[-1]}"
