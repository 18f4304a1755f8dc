"""A played episode, as the scorer writes it down. Reads the truth. Pure."""

import math
from collections.abc import Mapping, Sequence

from surefetch.common.cell import Cell
from surefetch.common.hypotheses import ABS, UNOBS, parse_tracked, tracked
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.evaluation.recordings.recording import RecordingTruth
from surefetch.evaluation.recordings.walk import target_track_of, true_hypothesis
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.episode import Moment, Played
from surefetch.evaluation.replaying.results import (
    MOST_HYPOTHESES,
    EpisodeResult,
    GraspResult,
    StepResult,
)
from surefetch.evaluation.replaying.scene import RecordedScene
from surefetch.evaluation.replaying.world import Report
from surefetch.evaluation.running.metrics import Scored, Verdict, realized_cost, verdict
from surefetch.planner.actions import Costs

Bodies = Mapping[str, str | None]


def score(
    played: Played,
    one: Contender,
    scene: RecordedScene,
    bodies: Bodies,
    cell: Cell,
    *,
    finished_live: bool = False,
) -> EpisodeResult:
    """Everything about an episode; `bodies` are those under each detection."""
    moments, truth = played.moments, scene.truth
    done = [(m.choice, m.report) for m in moments if m.choice is not None and m.report is not None]
    moved = [(choice, report) for choice, report in done if not isinstance(choice, Defer)]
    grasps = tuple(_grasps(moments, truth))
    found = verdict(
        played.end.outcome,
        played.end.reason,
        target=truth.target,
        grasped=[g.body for g in grasps if g.body is not None and not g.injected],
        anything_seen=bool(moments) and bool(moments[-1].believed.tracks),
    )
    return result(
        one,
        scene,
        found,
        cost=sum(cost_of(choice, cell) for choice, _ in moved),
        n_actions=len(moved),
        outcome=played.end.outcome,
        reason=played.end.reason,
        why=played.end.because,
        actions=tuple(told(choice, report) for choice, report in done),
        duration_s=sum(report.duration_s for _, report in done)
        + sum(moment.perception_s for moment in moments),
        commit_p=_commit_p(moments, grasps),
        grasps=grasps,
        finished_live=finished_live,
        steps=tuple(_steps(moments, truth, bodies, remembers=one.remembers)),
    )


def result(
    one: Contender,
    scene: RecordedScene,
    found: Verdict,
    *,
    cost: float,
    n_actions: int,
    **rest: object,
) -> EpisodeResult:
    """With what is the same for all episodes of this contender on this scene."""
    recording = scene.recording
    scored = Scored(recording.family, recording.seed, found, n_actions, cost)
    return EpisodeResult(
        policy=one.label,
        profile=one.profile.name,
        variant=one.variant,
        family=recording.family,
        seed=recording.seed,
        stratum=scene.stratum,
        covered=recording.covered,
        asked=recording.target.relation,
        target_present=scene.truth.target is not None,
        verdict=found,
        n_actions=n_actions,
        cost=cost,
        realized_cost=realized_cost(scored),
        q_hat=one.q_hat if math.isfinite(one.q_hat) else "inf",
        **rest,  # type: ignore[arg-type]
    )


def told(choice: Choice, report: Report) -> str:
    """An action, readable; what was tried in vain is marked."""
    match choice:
        case Inform(name=name):
            word = name
        case Grasp(track=track, relation=relation):
            word = f"grasp {track} {relation}"
        case Defer():
            word = "defer"
    return marked(word, report)


def marked(word: str, report: Report) -> str:
    """An action's word, with a mark when it was tried in vain."""
    if report.done:
        return word
    return f"{word} (failed, injected)" if report.injected else f"{word} (failed)"


def cost_of(choice: Choice, cell: Cell) -> float:
    """The planner's constant of one action."""
    match choice:
        case Inform(name=name):
            return cell.inform(name).cost
        case Grasp():
            return Costs().grasp
        case Defer():
            return 0.0


def _grasps(moments: Sequence[Moment], truth: RecordingTruth) -> list[GraspResult]:
    return [
        GraspResult(
            track=choice.track,
            relation=choice.relation,
            p=moment.believed.belief.get(tracked(choice.track, choice.relation), 0.0),
            body=report.body,
            on_target=report.body is not None and report.body == truth.target,
            held=report.done,
            injected=report.injected,
        )
        for moment in moments
        if isinstance(choice := moment.choice, Grasp) and (report := moment.report) is not None
    ]


def _commit_p(moments: Sequence[Moment], grasps: Sequence[GraspResult]) -> float:
    if grasps:
        return grasps[-1].p
    now = moments[-1].now if moments else None
    return 0.0 if now is None or not now.grasps else now.grasps[0].p


def _steps(
    moments: Sequence[Moment], truth: RecordingTruth, bodies: Bodies, *, remembers: bool
) -> list[StepResult]:
    steps: list[StepResult] = []
    target: int | None = None
    for moment in moments:
        earlier = target if remembers else None
        target = target_track_of(moment.believed, bodies, truth.target, earlier)
        steps.append(_step(moment, true_hypothesis(truth, target)))
    return steps


def _step(moment: Moment, z_true: str) -> StepResult:
    belief, heard = moment.believed.belief, moment.heard
    named = [(z, p) for z, p in belief.items() if parse_tracked(z) is not None]
    heaviest = sorted(named, key=lambda pair: -pair[1])[:MOST_HYPOTHESES]
    choice, report = moment.choice, moment.report
    return StepResult(
        view=heard.state.view,
        cover=heard.state.cover,
        q=heard.q,
        counted=heard.counted,
        delivered=moment.delivered,
        observations=tuple(f"{a.track} {a.y}" for a in moment.believed.assigned if a.counted),
        belief=dict(heaviest),
        unobs=belief[UNOBS],
        abs=belief[ABS],
        gamma=moment.believed.gamma,
        z_true=z_true,
        p_true=belief.get(z_true, 0.0),
        action=None if choice is None else told(choice, report or Report(done=True)),
        because=moment.because,
        planning_s=moment.planning_s,
    )
