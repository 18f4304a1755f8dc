"""`surefetch study fit` from recordings on disk: what it writes, and what it says."""

from pathlib import Path

import numpy as np
import pytest
from made_up_recording import made_with, shot

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.messages import (
    Answer,
    Answers,
    Box3d,
    Detection,
    FrameId,
    Mask,
    Observations,
    Target,
)
from surefetch.common.parameters import read_parameters
from surefetch.evaluation.fitting import fit_command as study_fit
from surefetch.evaluation.fitting.evidence_switches import SWITCHES
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.recordings.recording import (
    FORMAT,
    BodyMatch,
    Recording,
    RecordingTruth,
    Shot,
    ShotTruth,
    State,
    states,
)
from surefetch.evaluation.scenes.truth import SceneTruth

CELL = simulated_cell()
PLACES = {"target": (0.9, -0.1, 0.03), "twin": (0.9, 0.2, 0.03)}
MEMBERSHIP = {"target": "inside", "twin": "outside"}


def detection(state: State, body: str) -> Detection:
    def answer(label: str) -> Answer:
        return Answer(label=label, scores=(0.0, 0.0, 0.0))

    return Detection(
        id=f"{state.view}-{body}",
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        phrase="cube",
        mask=Mask(height=1, width=1, counts=(1,)),
        group=0,
        representative=True,
        center_world_m=PLACES[body],
        solid=Box3d(center_world_m=PLACES[body], size_m=(0.05, 0.05, 0.05), yaw_rad=0.0),
        points_world_m=np.zeros((0, 3), np.float32),
        hist=None,
        answers=Answers(
            color=answer("supported"),
            shape=answer("supported"),
            marking=None,
            membership=answer(MEMBERSHIP[body]),
        ),
    )


def seen(state: State) -> Shot:
    return shot(
        state,
        Observations(
            frame=FrameId(boot="b", counter=0),
            backend="made-up",
            detections=tuple(detection(state, body) for body in PLACES),
            container=None,
            cover="open",
            obstacles=(),
            obstacle_points_world_m=np.zeros((0, 3), np.float32),
            duration_s=0.0,
        ),
    )


def record(folder: Path, seed: int) -> None:
    """The target in the box, and beside it a twin that is not in it."""
    reached = states(False, CELL)
    recording = Recording(
        format=FORMAT,
        family="ambiguous",
        seed=seed,
        made_with=made_with("made-up"),
        sentence="the red cube inside the box",
        target=Target(noun="cube", color="red", shape="cube", relation="inside"),
        covered=False,
        shots=tuple(seen(state) for state in reached),
        feasible=(),
        repeated=None,
        durations_s={},
    )
    truth = RecordingTruth(
        format=FORMAT,
        family="ambiguous",
        seed=seed,
        target="target",
        relation="inside",
        graspable=("target",),
        matches={
            "target": BodyMatch(color=True, shape=True, marking=None, relation="inside"),
            "twin": BodyMatch(color=True, shape=True, marking=None, relation="outside"),
        },
        shots=tuple(
            ShotTruth(state=state, bodies={f"{state.view}-{body}": body for body in PLACES})
            for state in reached
        ),
    )
    scene = SceneTruth(
        family="ambiguous",
        seed=seed,
        generator_version=1,
        attempts=1,
        rejected={},
        stratum="",
        target="target",
        relation="inside",
        near_misses=(),
        twins=("twin",),
        too_wide=(),
        sightings=(),
        evidence={},
    )
    recording_store.save(folder, recording, truth, scene)


@pytest.fixture
def recordings(tmp_path: Path) -> Path:
    for seed in range(100_000, 100_004):
        record(tmp_path / "dev", seed)
    return tmp_path / "dev"


def test_paper_is_fitted_with_every_switch_off_and_extended_with_them_on(
    recordings: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert study_fit.main([str(recordings), "--out", str(tmp_path)]) == 0
    paper, extended = (read_parameters(tmp_path / f"{p}.json") for p in ("paper", "extended"))
    assert (paper.asked_prior, paper.attribute_evidence, paper.tempering) == (None, None, 0.5)
    assert (paper.cover_prior, paper.births) == (None, None)
    assert extended.asked_prior is not None
    assert extended.asked_prior["inside"].relation["inside"] == pytest.approx(5 / 6)
    assert extended.belief_priors("inside").relation["inside"] == pytest.approx(17 / 18)
    assert extended.births is not None
    assert extended.births["right"]["open"].without == (8, 0, 0)
    assert extended.attribute_evidence is not None
    answered = extended.attribute_evidence
    assert answered.membership["center"] == {"inside": (4, 0, 0), "outside": (0, 4, 0)}
    assert answered.distractors["inside"]["color shape"]["outside"] == (4, 0, 0, 0)
    said = capsys.readouterr().out
    assert "looks at 4 scenes" in said
    assert all(f"{name} " in said for name in SWITCHES)


def test_a_switch_can_be_left_off(recordings: Path, tmp_path: Path) -> None:
    without = ["--without", "attribute_evidence", "--without", "tempering"]
    study_fit.main([str(recordings), "--out", str(tmp_path), *without])
    extended = read_parameters(tmp_path / "extended.json")
    assert extended.attribute_evidence is None
    assert extended.tempering == 0.5
    assert extended.asked_prior is not None


def test_scenes_of_one_half_are_fitted_and_not_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record(tmp_path / "dev", 100_000)
    assert study_fit.main([str(tmp_path / "dev"), "--out", str(tmp_path)]) == 0
    assert "needs scenes of even and of odd seeds" in capsys.readouterr().out


def test_scenes_of_another_split_are_refused(tmp_path: Path) -> None:
    record(tmp_path / "dev", 300_000)
    with pytest.raises(BadInput, match="development scenes only"):
        study_fit.main([str(tmp_path / "dev"), "--out", str(tmp_path / "out")])
    assert not (tmp_path / "out").exists()
