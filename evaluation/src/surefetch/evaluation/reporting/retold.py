"""A replayed episode as an observer on the bus would have seen it, so that it can be drawn. Pure.

Pictures and detections come from the recording, beliefs and actions from the result. What followed
after an episode had left its recording is told without detections.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Final, cast

import numpy as np
from msgspec import structs

from surefetch.common.hypotheses import ABS, UNOBS, Relation, parse_tracked
from surefetch.common.instruction import describe
from surefetch.common.messages import (
    Accepted,
    Acted,
    Believed,
    Captured,
    Choice,
    Decided,
    Defer,
    Ended,
    Event,
    Feasibility,
    Frame,
    FrameId,
    FrameInfo,
    Grasp,
    Happening,
    Inform,
    Observations,
    QValue,
    TrackSummary,
)
from surefetch.evaluation.recordings.histories import Known
from surefetch.evaluation.recordings.pictures import Pictures
from surefetch.evaluation.recordings.recording import Looks, Recording, State
from surefetch.evaluation.replaying.results import EpisodeResult, StepResult
from surefetch.evaluation.showing.observed import Observed, Seen

FAILED: Final = " (failed"
NOTHING_ASKED: Final = Feasibility(grasps=(), informs=(), duration_s=0.0)


@dataclass(frozen=True, eq=False)
class _Turn:
    """One look and what followed."""

    number: int
    step: StepResult
    seen: Observations
    """Under this turn's frame."""
    frame: Frame
    tracks: tuple[TrackSummary, ...]
    eligible: bool


def retold(episode: EpisodeResult, recording: Recording, pictures: Pictures) -> Observed:
    """The episode, its recorded frames included. Raises BadInput for a state without a picture."""
    turns = list(_turns(episode, recording, pictures))
    log: list[Seen] = [_event(episode, 0, _accepted(episode, recording))]
    for turn in turns:
        log.append(turn.seen)
        log += [_event(episode, turn.number, one) for one in _happenings(turn)]
    log.append(_event(episode, len(turns), _ended(episode)))
    return Observed(tuple(log), {turn.frame.info.frame: turn.frame for turn in turns})


def _turns(episode: EpisodeResult, recording: Recording, pictures: Pictures) -> Iterator[_Turn]:
    known = Known()
    looks: list[State] = []
    for number, step in enumerate(episode.steps):
        state = State(view=step.view, cover=step.cover)
        looks.append(state)
        seen = recording.shot(state)
        known = known.after(step.view, seen)
        tracks = tuple(
            TrackSummary(id=t.id, center_world_m=t.center_world_m, n_observations=1, y0=None)
            for t in known.tracks
        )
        name = FrameId(boot="recorded", counter=number)
        yield _Turn(
            number=number,
            step=step,
            seen=structs.replace(seen, frame=name),
            frame=_frame(recording, state, pictures, name),
            tracks=tracks,
            eligible=_eligible(episode, step, recording, tuple(looks)),
        )


def _eligible(episode: EpisodeResult, step: StepResult, recording: Recording, looks: Looks) -> bool:
    """Whether one hypothesis of Γ fits the sentence, and its object can be grasped."""
    if step.action is not None and step.action.startswith("grasp"):
        return True
    named = [parsed for z in step.gamma if (parsed := parse_tracked(z)) is not None]
    fitting = [track for track, relation in named if episode.asked in ("any", relation)]
    if len(fitting) != 1 or step.cover == "closed":
        return False
    can = recording.feasible_after(looks).feasibility.grasps
    return any(verdict.feasible for verdict in can if verdict.track == fitting[0])


def _happenings(turn: _Turn) -> Iterator[Happening]:
    step, choice = turn.step, _choice(turn.step.action)
    yield Captured(frame=turn.frame.info.frame, view=step.view, q=step.q)
    yield Believed(
        q=step.q,
        belief={**step.belief, UNOBS: step.unobs, ABS: step.abs},
        gamma=step.gamma,
        tracks=turn.tracks,
        counted=step.observations,
    )
    yield Decided(
        choice=choice,
        q_values=(QValue(action="grasp", value=0.0),) if turn.eligible else (),
        because=step.because,
        feasibility=NOTHING_ASKED,
        duration_s=step.planning_s,
    )
    if step.action is not None and not isinstance(choice, Defer):
        failed = FAILED in step.action
        yield Acted(
            cmd_id=f"{turn.number}",
            action=step.action.partition(FAILED)[0],
            status="failed" if failed else "done",
            why="",
            duration_s=0.0,
        )


def _choice(action: str | None) -> Choice | None:
    if action is None:
        return None
    word, *rest = action.partition(FAILED)[0].split(" ")
    if word == "defer":
        return Defer()
    if word == "grasp":
        return Grasp(track=int(rest[0]), relation=cast(Relation, rest[1]))
    return Inform(name=word)


def _accepted(episode: EpisodeResult, recording: Recording) -> Accepted:
    return Accepted(
        episode=_name(episode), target=recording.target, understood=describe(recording.target)
    )


def _ended(episode: EpisodeResult) -> Ended:
    last = episode.grasps[-1] if episode.grasps and episode.outcome == "grasped" else None
    return Ended(
        outcome=cast(Any, episode.outcome),
        reason=episode.reason or "ended",
        because=f"{episode.verdict.replace('_', ' ')}. {episode.why}",
        track=None if last is None else last.track,
        relation=None if last is None else last.relation,
        delivered=None,
        actions=(),
        steps=(),
        q_hat=episode.threshold,
        durations={},
    )


def _frame(recording: Recording, state: State, pictures: Pictures, name: FrameId) -> Frame:
    shot = next(shot for shot in recording.shots if shot.state == state)
    rgb = pictures.rgb(state)
    height, width = rgb.shape[:2]
    info = FrameInfo(
        frame=name,
        view=state.view,
        width=width,
        height=height,
        K=shot.K,
        T_world_camera=shot.T_world_camera,
        captured_s=0.0,
    )
    depth_m = np.zeros((height, width), np.float32)
    return Frame(info=info, rgb=rgb, depth_m=depth_m, q_rad=shot.q_rad, gripper_width_m=0.0)


def _event(episode: EpisodeResult, step: int, happening: Happening) -> Event:
    return Event(episode=_name(episode), seq=0, step=step, happening=happening)


def _name(episode: EpisodeResult) -> str:
    return f"{episode.family}:{episode.seed}"


def first_trace(episodes: Sequence[EpisodeResult]) -> EpisodeResult | None:
    """The episode that is shown in full.

    The first of the ambiguous family, by seed, that used at least two views and succeeded.
    """
    fitting = [
        e
        for e in episodes
        if e.family == "ambiguous" and e.verdict == "success" and len({s.view for s in e.steps}) > 1
    ]
    return min(fitting, key=lambda e: e.seed, default=None)


def first_failures(episodes: Sequence[EpisodeResult]) -> list[EpisodeResult]:
    """The first failure of each family, by seed."""
    failed = sorted((e for e in episodes if e.verdict != "success"), key=lambda e: e.seed)
    return list({e.family: e for e in reversed(failed)}.values())[::-1]
