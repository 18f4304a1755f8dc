"""One closed-loop episode of a study, as a row of its table; a bad one is kept as a run."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

from msgspec import structs

from surefetch.common.cell import Cell, simulated_cell
from surefetch.common.errors import InfrastructureError
from surefetch.common.journal import parse_journal
from surefetch.common.messages import AskTruth, BeliefReply, Ended, Event, Injection, Instruct
from surefetch.common.topics import BELIEF, TRUTH, UPDATE
from surefetch.evaluation.recordings import labels
from surefetch.evaluation.running import artifacts, scoring, summary
from surefetch.evaluation.running import causes as study_causes
from surefetch.evaluation.running.live import Finished, Live
from surefetch.evaluation.scenes.generate import GeneratedScene, generate
from surefetch.planner.actions import Costs

TRUTH_S: Final = 10.0


@dataclass(frozen=True)
class KeptAs:
    """What the episodes of a study have in common, and where runs are kept."""

    profile: str
    policy: str
    folder: Path
    injected: tuple[Injection, ...] = ()


def run_one(live: Live, kept: KeptAs, family: str, seed: int) -> dict[str, Any]:
    scene = generate(family, seed)
    asked = Instruct(sentence=scene.sentence, profile=kept.profile, policy=kept.policy)
    try:
        table = structs.replace(scene.scene, injected=kept.injected)
        finished = live.run(asked, table, _show_nothing)
    except InfrastructureError as error:
        return _not_begun(family, seed, scene, error)
    ended = finished.ended
    score = scoring.score(ended, scoring.Asked(scene.truth.target), finished.truth)
    found = _findings(live, finished, scene, score)
    row = {
        "family": family,
        "seed": seed,
        "begun": bool(ended.steps) or ended.outcome != "aborted",
        "stratum": scene.truth.stratum,
        "sentence": scene.sentence,
        "target": scene.truth.target,
        "relation": scene.truth.relation,
        "outcome": ended.outcome,
        "reason": ended.reason,
        "because": ended.because,
        "verdict": score.verdict or "aborted",
        "touched": [] if finished.truth is None else list(finished.truth.touched),
        "delivered": ended.delivered,
        "track": ended.track,
        "actions": summary.actions(ended),
        "cost": _cost(ended, simulated_cell()),
        "durations": {**ended.durations, "total": finished.wall_s},
        **asdict(found),
    }
    if score.verdict != "success":
        _keep(kept, live, scene, finished, score, row)
    return row


def _show_nothing(_: Event) -> None:
    """Many episodes are told in a line each."""


def _not_begun(
    family: str, seed: int, scene: GeneratedScene, error: InfrastructureError
) -> dict[str, Any]:
    return {
        "family": family,
        "seed": seed,
        "begun": False,
        "stratum": scene.truth.stratum,
        "outcome": "aborted",
        "reason": "not_begun",
        "because": str(error),
        "verdict": "aborted",
        "actions": [],
        "cost": 0.0,
        "cause": "infrastructure",
        "why": str(error),
    }


def _findings(
    live: Live, finished: Finished, scene: GeneratedScene, score: scoring.Score
) -> study_causes.Findings:
    under: dict[str, str | None] = {}
    if finished.truth is not None:
        for frame, seen in finished.observed.observations.items():
            truth = live.cell.bus.ask(TRUTH, AskTruth(frame=frame), timeout_s=TRUTH_S)
            if truth.segmentation is not None:
                names = [body.name for body in truth.bodies]
                under |= labels.bodies_under(seen, truth.segmentation, names)
    return study_causes.findings(
        score.verdict,
        finished.ended,
        finished.observed.events,
        _replies(finished),
        under,
        target=scene.truth.target,
        relation=scene.truth.relation,
    )


def _replies(finished: Finished) -> list[BeliefReply]:
    """The belief service's answers, from its journal."""
    if BELIEF not in finished.journals:
        return []
    journal = parse_journal(finished.journals[BELIEF], "of the belief service")
    return [
        record.message(BeliefReply)
        for record in journal.records
        if record.kind == "reply" and record.topic == UPDATE.name
    ]


def _cost(ended: Ended, cell: Cell) -> float:
    """The planner's constants of the actions that were taken."""
    rows = cell.rows(views_while_covered=True)
    costs = {row.name: row.cost for row in rows} | {"grasp": Costs().grasp}
    return sum(costs.get(action.action, 0.0) for action in ended.actions)


def _keep(
    kept: KeptAs,
    live: Live,
    scene: GeneratedScene,
    finished: Finished,
    score: scoring.Score,
    row: dict[str, Any],
) -> None:
    """Leave the run of an episode that did not end well, for `surefetch view`."""
    told = summary.summarize(
        scene=f"{row['family']}:{row['seed']}",
        instruction=scene.sentence,
        profile=kept.profile,
        policy=kept.policy,
        accepted=finished.accepted,
        ended=finished.ended,
        score=score,
        wall_s=finished.wall_s,
        services=live.cell.statuses,
        missing=finished.missing,
    )
    folder = kept.folder / f"{row['family']}-{row['seed']}"
    artifacts.write(folder, told | {"truth": row}, finished.observed, finished.journals)
