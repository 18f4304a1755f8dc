"""A replayed episode is the live one, shares its outcomes, and knows nothing of the truth."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from recorded_table import body, numbers, record, save
from scripted_table import CELL, Table, scripted_cell, thing, thing_inside

from surefetch.common.cell import InformRow
from surefetch.common.errors import BadInput
from surefetch.common.injections import KINDS, Injector, kind_of
from surefetch.common.messages import (
    Choice,
    Defer,
    Ended,
    Feasibility,
    Grasp,
    Inform,
    InformVerdict,
    InjectedKind,
    Injection,
    Observations,
)
from surefetch.common.parameters import write_parameters
from surefetch.evaluation.policies.observation import Observation, Policy
from surefetch.evaluation.policies.planned import Planned
from surefetch.evaluation.policies.registry import HINDSIGHT, ORACLE, POLICIES
from surefetch.evaluation.recordings.free_space import FREE, SHAPE, UNSEEN, FreeSpace
from surefetch.evaluation.recordings.measured import Attempt, Measured
from surefetch.evaluation.recordings.recording import (
    FeasibleAfter,
    Recording,
    RecordingTruth,
    State,
)
from surefetch.evaluation.replaying import command, manifest, results
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.contenders import contender
from surefetch.evaluation.replaying.episode import OUT_OF_RECORDING, Errand, Played, play
from surefetch.evaluation.replaying.evaluate import Conditions, evaluate, world_of
from surefetch.evaluation.replaying.outcomes import Drawn, Outcome, Rates
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.replaying.scene import ready
from surefetch.evaluation.replaying.sitting import Sitting
from surefetch.planner.profiles import PROFILES

NEVER_FAILS = Conditions(rates=Rates(1.0, 1.0, 1.0))
RED_AND_BLUE = (thing(0.9, -0.1), thing(0.9, 0.1, "other"))
UNREAD_FIRST = (thing(0.9, -0.1, center="unread"), thing(0.9, 0.1, "other", center="unread"))
TABLES = {
    "one is clear": Table(RED_AND_BLUE),
    "it must be looked at": Table(UNREAD_FIRST),
    "nothing fits": Table((thing(0.9, -0.1, "other"), thing(0.9, 0.1, "other"))),
    "two fit": Table((thing(0.9, -0.1), thing(0.9, 0.1))),
    "it is under the cover": Table((thing_inside(), thing(0.8, 0.2, "other")), covered=True),
    "nothing is there": Table(()),
}


@dataclass(frozen=True)
class ByScript:
    """Outcomes as a live table's script has them: by action, what becomes of each try."""

    fails: Mapping[str, Sequence[str]] = field(default_factory=dict)

    def informs(self, row: InformRow, attempt: int) -> Outcome:
        return self._works(row.name, attempt)

    def grasps(self, body: str | None, attempt: int) -> Outcome:
        return self._works("grasp", attempt) if body is not None else Outcome(False)

    def _works(self, action: str, attempt: int) -> Outcome:
        script = self.fails.get(action, ())
        return Outcome(attempt > len(script) or script[attempt - 1] == "done")


def replayed(
    policy: Policy,
    recorded: tuple[Recording, RecordingTruth],
    profile: str = "extended",
    fails: Mapping[str, Sequence[str]] | None = None,
    injected: tuple[Injection, ...] = (),
) -> Played:
    recording, truth = recorded
    scene = ready(recording, truth)
    world = RecordedWorld(scene, ByScript(fails or {}), Injector(recording.family, 0, injected))
    parameters = numbers(profile)
    errand = Errand(recording.target, CELL, parameters, PROFILES[profile])
    beliefs = Beliefs(recording.target.relation, recording.backend, parameters, "full", 0.9)
    return play(policy, errand, world, beliefs, np.random.default_rng(0))


def evaluated(
    recorded: Sequence[tuple[Recording, RecordingTruth]],
    labels: Sequence[str],
    conditions: Conditions,
    profile: str = "extended",
) -> dict[str, list[EpisodeResult]]:
    parameters = {name: numbers(name) for name in PROFILES}
    contenders = [contender(label, profile, parameters) for label in labels]
    played = [list(evaluate(ready(*one), contenders, CELL, conditions)) for one in recorded]
    return {label: [scene[n] for scene in played] for n, label in enumerate(labels)}


def names(taken: Sequence[Choice]) -> list[str]:
    return [
        choice.name if isinstance(choice, Inform) else "grasp"
        for choice in taken
        if not isinstance(choice, Defer)
    ]


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize(
    "fails", [{}, {"right": ["failed"]}, {"grasp": ["failed"] * 3}, {"remove_cover": ["failed"]}]
)
def test_a_replay_takes_the_actions_of_the_live_services(
    profile: str, name: str, fails: dict[str, list[str]]
) -> None:
    table = TABLES[name]
    live = Table(table.things, covered=table.covered, fails=fails)
    with scripted_cell(live) as cell:
        accepted = cell.instruct(profile=profile, after_grasp="hold")
        ended = cell.events()[-1].happening
    assert isinstance(ended, Ended)
    played = replayed(
        Planned(), record(table, wanted=0 if table.things else None, target=accepted.target),
        profile, fails,
    )  # fmt: skip
    moved = [a.action for a in ended.actions if a.action not in ("look", "put_back")]
    assert names(played.taken) == moved
    assert (played.end.outcome, played.end.reason) == (ended.outcome, ended.reason)
    assert played.end.track == ended.track


@pytest.mark.parametrize("name", POLICIES)
@pytest.mark.parametrize("of", TABLES)
def test_no_action_changes_when_the_truth_is_poisoned(name: str, of: str) -> None:
    """Another target, bodies permuted and renamed, detections, family and seed renamed."""
    recorded = record(TABLES[of], wanted=0 if TABLES[of].things else None)
    make = POLICIES[name].make
    told = replayed(make(), recorded)
    poisoned = replayed(make(), disguised(*recorded))
    assert poisoned.taken == told.taken
    assert [m.believed.belief for m in poisoned.moments] == [
        m.believed.belief for m in told.moments
    ]


def disguised(recording: Recording, truth: RecordingTruth) -> tuple[Recording, RecordingTruth]:
    """The same to see; nothing else is left as it was."""
    shots = tuple(
        msgspec.structs.replace(shot, observations=_renamed(shot.observations))
        for shot in recording.shots
    )
    poisoned = msgspec.structs.replace(
        truth,
        family="absent",
        seed=7,
        target=body(1) if truth.target is None else None,
        relation="inside" if truth.target is None else None,
        shots=tuple(
            msgspec.structs.replace(shot, bodies=_permuted(shot.bodies)) for shot in truth.shots
        ),
    )
    return msgspec.structs.replace(recording, family="absent", seed=7, shots=shots), poisoned


def _renamed(seen: Observations) -> Observations:
    detections = tuple(msgspec.structs.replace(d, id=f"x{d.id}") for d in seen.detections)
    return msgspec.structs.replace(seen, detections=detections)


def _permuted(bodies: dict[str, str | None]) -> dict[str, str | None]:
    others = [None if under is None else f"no {under}" for under in reversed(bodies.values())]
    return dict(zip([f"x{name}" for name in bodies], others, strict=True))


class Spy:
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.told: list[Observation] = []

    def act(self, now: Observation) -> Choice:
        self.told.append(now)
        return Inform(name=now.informs[0].name) if now.informs else Defer()


def test_a_policy_is_not_told_the_family_the_seed_or_a_body() -> None:
    spy = Spy()
    replayed(spy, record(TABLES["it must be looked at"], wanted=0, seed=123_456))
    assert len(spy.told) == 3
    for now in spy.told:
        told = repr((now.target, now.believed, now.feasibility, now.used, now.cover))
        assert not any(secret in told for secret in ("partial", "123456", "body"))


def test_a_policy_is_told_the_free_space_of_all_looks_so_far_and_of_no_other() -> None:
    recording, truth = record(TABLES["it must be looked at"], wanted=0)
    grids = [np.full(SHAPE, UNSEEN, np.int8) for _ in recording.shots]
    for n, grid in enumerate(grids):
        grid[n] = FREE
    shots = tuple(
        msgspec.structs.replace(shot, free_space=FreeSpace.of(grid))
        for shot, grid in zip(recording.shots, grids, strict=True)
    )
    spy = Spy()
    replayed(spy, (msgspec.structs.replace(recording, shots=shots), truth))
    for n, now in enumerate(spy.told, start=1):
        assert (now.free_space == FREE).all(axis=(1, 2)).tolist() == [
            k < n for k in range(SHAPE[0])
        ]


def test_the_first_try_comes_out_the_same_whenever_it_is_made() -> None:
    tables = [
        record(TABLES["one is clear"], wanted=0, seed=seed) for seed in range(100_000, 100_200)
    ]
    labels = ("greedy", "exhaustive-look", ORACLE)
    played = evaluated(tables, labels, Conditions(rates=Rates(view=1.0, grasp=0.5)), "paper")
    ends = [[episode.verdict for episode in played[label]] for label in labels]
    assert ends[0] == ends[1] == ends[2]
    assert 60 < ends[0].count("grasp_failed") < 140


def test_equal_looks_at_one_scene_deliver_the_same_to_every_policy() -> None:
    """By belief, profile and policy nothing differs but what is made of it."""
    recorded = [record(TABLES[of], wanted=0) for of in ("two fit", "it is under the cover")]
    labels = [name for name in POLICIES if name not in ("ours", "paper-method")]
    labels += [f"{name}@paper" for name in ("a1", "a2", "a3", "exhaustive-look", "random")]
    for scene in zip(*evaluated(recorded, labels, NEVER_FAILS).values(), strict=True):
        delivered: dict[tuple[str, str, bool], str] = {}
        for episode in scene:
            for step in episode.steps:
                look = step.view, step.cover, step.counted
                assert delivered.setdefault(look, step.delivered) == step.delivered
        assert len(set(delivered.values())) == len(delivered)


@pytest.mark.parametrize(("rate", "low", "high"), [(0.0, 0, 0), (0.9, 420, 480), (1.0, 500, 500)])
def test_outcomes_come_at_their_rate(rate: float, low: int, high: int) -> None:
    drawn = [Drawn("partial", seed, Rates(grasp=rate)).grasps("b", 1) for seed in range(500)]
    assert low <= sum(outcome.done for outcome in drawn) <= high


def test_another_draw_gives_other_outcomes_at_the_same_rate() -> None:
    draws = [
        [Drawn("partial", seed, Rates(grasp=0.5), k).grasps("b", 1).done for seed in range(400)]
        for k in range(3)
    ]
    assert all(140 < sum(draw) < 260 for draw in draws)
    assert all(sum(a != b for a, b in zip(draws[0], d, strict=True)) > 100 for d in draws[1:])


def test_where_no_body_is_nothing_is_grasped() -> None:
    assert not Drawn("partial", 1, Rates(grasp=1.0)).grasps(None, 1).done


def test_what_was_not_recorded_ends_the_episode_and_is_counted() -> None:
    recording, truth = record(TABLES["it must be looked at"], wanted=0)
    short = msgspec.structs.replace(recording, shots=recording.shots[:1])
    (episode,) = evaluated([(short, truth)], ["ours"], NEVER_FAILS)["ours"]
    assert (episode.verdict, episode.reason) == ("aborted", OUT_OF_RECORDING)
    assert "partial:100000 was recorded without the view" in episode.why
    assert episode.actions == ("right",)
    assert len(episode.steps) == 1


def test_a_cover_that_only_perception_sees_leads_out_of_the_recording() -> None:
    recording, truth = record(TABLES["it is under the cover"], wanted=0)
    wrong = msgspec.structs.replace(recording, covered=False)
    shots = [
        msgspec.structs.replace(s, state=msgspec.structs.replace(s.state, cover="none"))
        for s in recording.shots[:1]
    ]
    first = msgspec.structs.replace(recording.feasible[0], looks=(shots[0].state,))
    wrong = msgspec.structs.replace(wrong, shots=tuple(shots), feasible=(first,))
    truths = [
        msgspec.structs.replace(s, state=msgspec.structs.replace(s.state, cover="none"))
        for s in truth.shots[:1]
    ]
    none = msgspec.structs.replace(truth, shots=tuple(truths))
    played = evaluated([(wrong, none)], ["exhaustive-look"], NEVER_FAILS, "paper")
    assert "where no cover is on" in played["exhaustive-look"][0].why


def after_all_looks(
    recording: Recording, change: Callable[[FeasibleAfter], FeasibleAfter]
) -> Recording:
    return msgspec.structs.replace(recording, feasible=tuple(map(change, recording.feasible)))


def test_what_the_robot_could_not_do_is_not_open() -> None:
    """Nothing can be grasped before it was seen from the right, and close_high never reached."""
    right = State(view="right", cover="none")
    unreached = InformVerdict(name="close_high", feasible=False, refusal="path", why="")

    def hinder(known: FeasibleAfter) -> FeasibleAfter:
        grasps = tuple(
            msgspec.structs.replace(v, feasible=right in known.looks)
            for v in known.feasibility.grasps
        )
        hindered = Feasibility(grasps=grasps, informs=(unreached,), duration_s=0.0)
        return msgspec.structs.replace(known, feasibility=hindered)

    recording, truth = record(TABLES["one is clear"], wanted=0)
    played = replayed(Planned(), (after_all_looks(recording, hinder), truth))
    assert names(played.taken) == ["right", "grasp"]
    spy = Spy()
    replayed(spy, (after_all_looks(recording, hinder), truth))
    assert [[row.name for row in now.informs] for now in spy.told] == [["right"], []]
    assert [bool(now.grasps) for now in spy.told] == [False, True]


def test_a_belief_without_memory_can_do_what_its_latest_look_allows() -> None:
    recording, truth = record(TABLES["it must be looked at"], wanted=0)
    alone = {known.looks for known in recording.feasible if len(known.looks) == 1}
    only = msgspec.structs.replace(
        recording, feasible=tuple(k for k in recording.feasible if k.looks in alone)
    )
    played = evaluated([(only, truth)], ["a2", "ours"], NEVER_FAILS)
    assert played["a2"][0].verdict == "success"
    assert played["ours"][0].reason == OUT_OF_RECORDING


def test_an_episode_takes_as_long_as_its_motions_and_its_perception() -> None:
    def timed(known: FeasibleAfter) -> FeasibleAfter:
        grasps_s = {v.track: 5.0 for v in known.feasibility.grasps}
        views_s = {"right": 2.0, "close_high": 1.0}
        return msgspec.structs.replace(known, informs_s=views_s, grasps_s=grasps_s)

    recording, truth = record(TABLES["it must be looked at"], wanted=0)
    shots = tuple(
        msgspec.structs.replace(
            shot, observations=msgspec.structs.replace(shot.observations, duration_s=0.5)
        )
        for shot in recording.shots
    )
    slow = after_all_looks(msgspec.structs.replace(recording, shots=shots), timed)
    played = evaluated([(slow, truth)], ["exhaustive-look"], NEVER_FAILS)
    (episode,) = played["exhaustive-look"]
    assert [action.split()[0] for action in episode.actions] == ["right", "close_high", "grasp"]
    assert episode.duration_s == pytest.approx(3 * 0.5 + 2.0 + 1.0 + 5.0)


class Careless:
    """Grasps a track that does not exist."""

    def act(self, _: Observation) -> Choice:
        return Grasp(track=99, relation="inside")


def test_an_action_that_is_not_open_is_refused() -> None:
    with pytest.raises(BadInput, match="not open to it"):
        replayed(Careless(), record(TABLES["one is clear"], wanted=0))


def test_an_episode_ends_at_the_profile_s_last_action() -> None:
    fails = {"right": ["failed"] * 9, "close_high": ["failed"] * 9}
    played = replayed(Planned(), record(TABLES["it must be looked at"], wanted=0), fails=fails)
    assert (played.end.outcome, played.end.reason) == ("failed", "view_failed")
    assert names(played.taken) == ["right"] * 3 + ["close_high"] * 3


def attempt(done: bool, moved_m: float = 0.0) -> Attempt:
    return Attempt(done=done, why="", moved_m=moved_m, turned_deg=0.0, duration_s=7.0)


def measured(removals: Sequence[Attempt] = (), grasps: Sequence[Attempt] = ()) -> Measured:
    return Measured(
        format=1, family="partial", seed=1, removals=tuple(removals), grasps=tuple(grasps)
    )


def as_measured(
    of: str, told: Measured, label: str = "ours", profile: str = "extended"
) -> EpisodeResult:
    scene = ready(*record(TABLES[of], wanted=0), measured=told)
    one = contender(label, profile, {name: numbers(name) for name in PROFILES})
    (episode,) = evaluate(scene, [one], CELL, Conditions("measured"))
    return episode


def test_measured_outcomes_come_in_their_order_with_their_durations() -> None:
    told = measured(grasps=[attempt(False), attempt(True)])
    episode = as_measured("one is clear", told, "greedy")
    assert [action.endswith("(failed)") for action in episode.actions] == [True, False]
    assert (episode.verdict, episode.duration_s) == ("success", 14.0)


def test_a_failure_that_moved_nothing_much_leaves_the_recording_valid() -> None:
    told = measured(grasps=[attempt(False, moved_m=0.0029), attempt(True)])
    assert as_measured("one is clear", told).verdict == "success"


def test_after_a_failure_that_moved_bodies_nothing_can_be_seen_any_more() -> None:
    told = measured(grasps=[attempt(False, moved_m=0.0031), attempt(True)])
    episode = as_measured("one is clear", told)
    assert (episode.verdict, episode.reason) == ("aborted", OUT_OF_RECORDING)
    assert "grasp failed and moved what stands there" in episode.why


def test_an_episode_that_leaves_its_recording_can_be_finished_elsewhere() -> None:
    told = measured(grasps=[attempt(False, moved_m=0.0031)])
    scene = ready(*record(TABLES["one is clear"], wanted=0), measured=told)
    numbers_of = {name: numbers(name) for name in PROFILES}
    contenders = [contender(name, "extended", numbers_of) for name in ("ours", "greedy")]

    def finish(
        sitting: Sitting, left: Played, world: RecordedWorld, beliefs: Beliefs
    ) -> tuple[Played, Mapping[str, str | None]]:
        """On a table that is as it was before."""
        assert world.disturbed is not None
        return sitting.play(world_of(scene, NEVER_FAILS), beliefs.apart(), left.turn), world.bodies

    for episode in evaluate(scene, contenders, CELL, Conditions("measured"), finish):
        assert (episode.verdict, episode.finished_live) == ("success", True)
        grasps = [action for action in episode.actions if action.startswith("grasp")]
        assert [action.endswith("(failed)") for action in grasps] == [True, False]


def test_a_failure_that_ends_the_episode_needs_nothing_more_to_be_seen() -> None:
    told = measured(grasps=[attempt(False, moved_m=0.1)])
    episode = as_measured("one is clear", told, "greedy", "paper")
    assert (episode.verdict, episode.reason) == ("grasp_failed", "grasp_failed")


def test_a_failed_removal_counts_like_a_failed_grasp() -> None:
    of, lifted = "it is under the cover", [attempt(True)]
    stays = measured(removals=[attempt(False), attempt(True)], grasps=lifted)
    assert as_measured(of, stays).actions.count("remove_cover (failed)") == 1
    moved = measured(removals=[attempt(False, moved_m=0.01), attempt(True)], grasps=lifted)
    assert as_measured(of, moved).reason == OUT_OF_RECORDING


def test_what_was_not_measured_is_not_made_up() -> None:
    assert "was not measured" in as_measured("one is clear", measured()).why


def test_the_oracle_suffers_what_was_measured() -> None:
    told = measured(grasps=[attempt(False, moved_m=1.0), attempt(True)])
    assert as_measured("one is clear", told, ORACLE).verdict == "success"
    assert as_measured("one is clear", told, ORACLE, "paper").verdict == "grasp_failed"
    assert as_measured("one is clear", measured(), ORACLE).verdict == "grasp_failed"


def test_the_oracle_opens_only_for_what_is_under_the_cover() -> None:
    covered = TABLES["it is under the cover"]
    scenes = [record(covered, wanted=w, seed=100_000 + n) for n, w in enumerate((0, 1, None))]
    episodes = evaluated(scenes, [ORACLE], NEVER_FAILS)[ORACLE]
    assert [e.verdict for e in episodes] == ["success"] * 3
    assert [e.n_actions for e in episodes] == [2, 1, 0]
    assert [e.outcome for e in episodes] == ["grasped", "grasped", "deferred"]
    assert episodes[0].cost == pytest.approx(0.168)


def test_an_episode_is_written_down_as_it_was_played() -> None:
    scene = record(TABLES["it is under the cover"], wanted=0)
    (episode,) = evaluated([scene], ["ours"], NEVER_FAILS)["ours"]
    (grasp,) = episode.grasps
    assert (episode.policy, episode.profile, episode.variant) == ("ours", "extended", "full")
    assert "remove_cover" in episode.actions
    assert episode.actions[-1] == f"grasp {grasp.track} inside"
    assert tuple(s.action for s in episode.steps) == episode.actions
    assert {s.z_true for s in episode.steps if s.cover == "closed"} == {"unobs"}
    assert {s.z_true for s in episode.steps if s.cover == "open"} == {f"{grasp.track}:inside"}
    assert (grasp.on_target, grasp.held) == (True, True)
    assert episode.commit_p == grasp.p == episode.steps[-1].p_true
    looks = [CELL.inform(name).cost for name in episode.actions[:-1]]
    assert episode.cost == pytest.approx(sum(looks) + 0.008)
    assert all(step.because for step in episode.steps)


def test_a_defer_is_scored_by_the_best_grasp_that_was_open() -> None:
    scene = record(TABLES["two fit"], wanted=0)
    (episode,) = evaluated([scene], ["always-defer"], NEVER_FAILS)["always-defer"]
    assert (episode.verdict, episode.actions) == ("false_defer", ("defer",))
    assert episode.commit_p == max(episode.steps[0].belief.values())
    assert episode.realized_cost == pytest.approx(0.8)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("of", TABLES)
def test_an_injected_failure_changes_only_what_is_reported(kind: InjectedKind, of: str) -> None:
    """Under rules that outlive failure, the same end comes one action of this kind later."""
    recorded = record(TABLES[of], wanted=0 if TABLES[of].things else None)
    plain = replayed(Planned(), recorded)
    struck = replayed(Planned(), recorded, injected=(Injection(kind=kind, occurrence=1),))
    mine = [c for c in plain.taken if not isinstance(c, Defer) and kind_of(c, CELL) == kind]
    assert len(struck.taken) - len(plain.taken) == (1 if mine else 0)
    assert (struck.end.outcome, struck.end.track) == (plain.end.outcome, plain.end.track)
    failed = [m.report for m in struck.moments if m.report and not m.report.done]
    assert [(r.injected, r.done) for r in failed] == [(True, False)] * bool(mine)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("of", TABLES)
def test_an_injected_failure_goes_as_a_failure_that_live_services_report(
    profile: str, of: str
) -> None:
    """Whatever is looked at or grasped first; the scripted arm does nothing when it fails."""
    table = TABLES[of]
    target = 0 if table.things else None
    first = next(iter(replayed(Planned(), record(table, wanted=target), profile).taken))
    kind = None if isinstance(first, Defer) else kind_of(first, CELL)
    if kind is None or isinstance(first, Defer):
        return
    name = first.name if isinstance(first, Inform) else "grasp"
    live = Table(table.things, covered=table.covered, fails={name: ["failed"]})
    with scripted_cell(live) as cell:
        accepted = cell.instruct(profile=profile, after_grasp="hold")
        ended = cell.events()[-1].happening
    assert isinstance(ended, Ended)
    struck = replayed(
        Planned(), record(table, wanted=target, target=accepted.target), profile,
        injected=(Injection(kind=kind, occurrence=1),),
    )  # fmt: skip
    moved = [a.action for a in ended.actions if a.action not in ("look", "put_back")]
    assert names(struck.taken) == moved
    assert (struck.end.outcome, struck.end.reason) == (ended.outcome, ended.reason)


def test_an_injected_failure_uses_up_no_attempt() -> None:
    """The first real attempt fails; reported failures before it do not take its place."""
    recorded = record(TABLES["one is clear"], wanted=0)
    played = replayed(
        Planned(),
        recorded,
        fails={"grasp": ["failed"]},
        injected=(Injection(kind="grasp", occurrence=1),),
    )
    reports = [m.report for m in played.moments if isinstance(m.choice, Grasp)]
    assert [(r.done, r.injected) for r in reports if r] == [
        (False, True), (False, False), (True, False)
    ]  # fmt: skip


def test_an_uncalibrated_belief_is_refused_with_the_command() -> None:
    full = {"full": numbers("extended").calibration()}
    parameters = {p: msgspec.structs.replace(numbers(p), calibrations=full) for p in PROFILES}
    with pytest.raises(BadInput, match="surefetch study calibrate"):
        contender("a1", "extended", parameters)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for profile in PROFILES:
        write_parameters(tmp_path / f"{profile}.json", numbers(profile))
    for n, table in enumerate(TABLES.values()):
        wanted = 0 if table.things else None
        recording, truth = record(table, wanted=wanted, seed=n)
        save(tmp_path / "recordings", recording, truth)
    return tmp_path


def test_the_command_prints_the_json_of_the_specification(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    assert command.main([*words, "--policies", "ours,always-defer", "--json"]) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert list(told) == ["policies"]
    assert list(told["policies"]) == ["ours", "always-defer"]
    row = told["policies"]["always-defer"]["families"]["partial"]
    assert set(row) == {"episodes", "successes", "wilson_95", "wrong_object", "false_defers"}
    assert (row["episodes"], row["successes"], row["false_defers"]) == (6, 1, 5)


def test_the_command_prints_tables_and_what_they_assume(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    assert command.main([*words, "--policies", "paper-method,a8,random,truth-oracle"]) == 0
    told = capsys.readouterr().out
    assert "paper-method" in told
    assert "realised cost" in told
    assert "assumed, not measured" in told


def test_what_was_played_is_not_played_again(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    words += ["--out", str(folder / "results"), "--json"]
    assert command.main([*words, "--policies", "ours"]) == 0
    first = (folder / "results/ours.jsonl").read_bytes()
    assert command.main([*words, "--policies", "greedy@paper,ours", "--jobs", "2"]) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert list(told["policies"]) == ["greedy@paper", "ours"]
    assert (folder / "results/ours.jsonl").read_bytes() == first
    found = manifest.read(folder / "results")
    assert found is not None and set(found.policies) == {"ours", "greedy@paper"}


def test_a_policy_that_changed_is_played_again(folder: Path) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    words += ["--out", str(folder / "results"), "--json", "--policies", "greedy"]
    assert command.main(words) == 0
    found = manifest.read(folder / "results")
    assert found is not None
    was = {"greedy": {**found.policies["greedy"], "code": "another"}}
    manifest.write(folder / "results", replace(found, policies=was))
    (folder / "results/greedy.jsonl").write_text("")
    assert command.main(words) == 0
    assert len(results.read(folder / "results", "greedy")) == len(TABLES)


def test_results_of_other_outcomes_are_not_mixed(folder: Path) -> None:
    words = ["--recordings", str(folder / "recordings"), "--parameters", str(folder)]
    words += ["--out", str(folder / "results"), "--policies", "greedy", "--json"]
    assert command.main(words) == 0
    with pytest.raises(BadInput, match="other outcomes"):
        command.main([*words, "--outcome-seed", "1"])


@pytest.mark.parametrize("label", ["ours@paper", "greedy@none", "nobody"])
def test_a_policy_with_a_profile_that_it_cannot_have_is_refused(label: str) -> None:
    with pytest.raises(BadInput):
        contender(label, "extended", {profile: numbers(profile) for profile in PROFILES})


def test_recordings_of_another_perception_are_refused(folder: Path) -> None:
    with pytest.raises(BadInput, match="Fit new ones"):
        command.main(["--recordings", str(folder / "recordings"), "--policies", "ours"])


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("of", TABLES)
def test_whatever_looking_and_grasping_comes_to_hindsight_comes_to(of: str, profile: str) -> None:
    """Whichever thing is wanted, or none; outcomes are drawn, and a failed grasp is one for all."""
    things = len(TABLES[of].things)
    lookers = ["greedy", "exhaustive-look", "best-fixed", "always-defer"]
    scenes = [
        record(TABLES[of], wanted=wanted, seed=100_000 + 2 * n + k)
        for k in range(2)
        for n, wanted in enumerate((None, *range(things)))
    ]
    conditions = Conditions(rates=Rates(0.7, 0.7, 0.7))
    played = evaluated(scenes, [*lookers, HINDSIGHT], conditions, profile)
    for n, best in enumerate(played[HINDSIGHT]):
        assert (best.policy, best.profile) == (HINDSIGHT, profile)
        for name in lookers:
            other = played[name][n]
            if other.verdict == "success":
                assert best.verdict == "success"
                assert best.realized_cost <= other.realized_cost


def test_hindsight_opens_only_where_opening_shows_the_target() -> None:
    covered = TABLES["it is under the cover"]
    scenes = [record(covered, wanted=w, seed=100_000 + n) for n, w in enumerate((0, None))]
    under, absent = evaluated(scenes, [HINDSIGHT], NEVER_FAILS)[HINDSIGHT]
    assert under.actions[0] == "remove_cover"
    assert under.verdict == absent.verdict == "success"
    assert absent.actions == ("defer",)
