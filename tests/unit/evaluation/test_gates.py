"""The controls do what they say, on scenes made up for the purpose."""

import numpy as np
import pytest
from made_up_looks import look
from made_up_recording import made_with

from surefetch.common.cell import simulated_cell
from surefetch.common.hypotheses import Relation
from surefetch.common.messages import Target
from surefetch.evaluation.fitting import gates
from surefetch.evaluation.fitting.gates import Walked
from surefetch.evaluation.recordings.recording import (
    FORMAT,
    Recording,
    RecordingTruth,
    exhaustive_path,
)

CELL = simulated_cell()
UNSURE = {"1:inside": 0.4, "1:outside": 0.1, "2:inside": 0.45, "unobs": 0.0, "abs": 0.05}
SURE = {"1:inside": 0.9, "1:outside": 0.01, "2:inside": 0.05, "unobs": 0.0, "abs": 0.04}


def walked(seed: int, *, covered: bool = False, relation: Relation | None = "inside") -> Walked:
    target = Target(noun="cube", relation="inside")
    recording = Recording(
        format=FORMAT,
        family="covered",
        seed=seed,
        made_with=made_with("made-up"),
        sentence="the cube inside the box",
        target=target,
        covered=covered,
        shots=(),
        feasible=(),
        repeated=None,
        durations_s={},
    )
    truth = RecordingTruth(
        format=FORMAT,
        family="covered",
        seed=seed,
        target=None if relation is None else "target",
        relation=relation,
        graspable=("target",),
        matches={},
        shots=(),
    )
    first = look("center", {1: "MI", 2: "MI"}, target_track=1, belief=UNSURE, relation=relation)
    last = look("right", {1: "MI", 2: "MI"}, target_track=1, belief=SURE, relation=relation)
    path = exhaustive_path(covered, CELL)
    walks = {(): [first], path: [first, last], exhaustive_path(False, CELL): [first, last]}
    return Walked(recording, truth, walks)


SCENES = [walked(seed) for seed in range(300)]


def test_looking_once_takes_the_wrong_one_and_looking_on_the_right_one() -> None:
    played = gates.play_all(SCENES, CELL)
    assert {e.verdict for e in played["look-once"]} == {"wrong_object"}
    assert gates.share(played["views-only"]) > 0.85
    assert gates.share(played["everything-threshold"]) > 0.85


def test_execution_alone_fails_the_oracle() -> None:
    verdicts = [gates.play_oracle(scene, CELL).verdict for scene in SCENES]
    assert set(verdicts) == {"success", "grasp_failed"}
    assert np.mean([v == "success" for v in verdicts]) == pytest.approx(gates.P_GRASP, abs=0.04)


def test_always_deferring_is_right_exactly_when_nothing_is_there() -> None:
    scenes = [walked(seed, relation=None if seed % 5 == 0 else "inside") for seed in range(50)]
    played = gates.play_all(scenes, CELL)
    assert gates.share(played["always-defer"]) == pytest.approx(0.2)


def test_the_same_first_try_has_the_same_outcome_for_everybody() -> None:
    grasped = [gates.play(gates.VIEWS_ONLY, s, CELL).verdict == "grasp_failed" for s in SCENES]
    oracle = [gates.play_oracle(s, CELL).verdict == "grasp_failed" for s in SCENES]
    assert all(o for g, o in zip(grasped, oracle, strict=True) if g)


def test_nothing_is_viewed_without_opening_when_a_cover_is_on() -> None:
    scene = walked(1, covered=True)
    assert gates.views_only(scene, CELL) == ()
    assert gates.everything(scene, CELL)[0] == "remove_cover"


def test_a_gate_is_kept_at_its_bound_and_broken_beyond() -> None:
    assert gates.Gate("look-once", None, 0.0, 0.55, 0.55).passed
    assert not gates.Gate("look-once", None, 0.0, 0.55, 0.56).passed
