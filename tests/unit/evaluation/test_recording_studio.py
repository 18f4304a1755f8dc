"""A recorded state is what a live run gets there."""

import msgspec
import numpy as np
import pytest
from made_up_episode import detection, observations

from surefetch.common.cell import simulated_cell
from surefetch.common.geometry import Array
from surefetch.common.messages import Mask, Observations
from surefetch.evaluation.recordings import studio as recording_studio
from surefetch.evaluation.recordings.labels import bodies_under
from surefetch.evaluation.recordings.recording import states
from surefetch.evaluation.recordings.studio import Studio
from surefetch.evaluation.scenes.generate import generate
from surefetch.executor.motion.collision import CollisionScene
from surefetch.executor.motion.obstacles import Obstacles
from surefetch.executor.motion.planner import MotionPlanner, Tool
from surefetch.executor.ports import Trajectory
from surefetch.executor.robot import ur10e

CELL = simulated_cell()
TOUCHED_RAD = 1e-5


def planned(start_rad: Array, end_rad: Array) -> Trajectory:
    """As the executor moves: planned, timed by the cell's speeds."""
    around = CollisionScene(ur10e.camera_mount(CELL.camera), Obstacles((), np.zeros((0, 3))))
    rng = np.random.default_rng(0)
    return MotionPlanner(CELL).to_joints(start_rad, end_rad[None], around, Tool(0.0), rng)


def labels(seen: Observations) -> list[tuple[str, ...]]:
    """What was answered, candidate by candidate."""
    return [
        tuple(
            "not asked" if answer is None else answer.label
            for answer in (
                one.answers.color,
                one.answers.shape,
                one.answers.marking,
                one.answers.membership,
            )
        )
        for one in seen.detections
        if one.answers is not None
    ]


def test_a_frame_does_not_depend_on_how_the_arm_came(monkeypatch: pytest.MonkeyPatch) -> None:
    """But for the micrometres in which it comes to rest, which move few pixels by one count."""
    made = generate("visible", 7)
    with Studio(made, CELL, "classical") as studio:
        frame = studio.frame(studio.capture("right"))
        seen = studio.perceive(frame.info.frame)
    monkeypatch.setattr(recording_studio, "_straight", planned)
    with Studio(made, CELL, "classical") as studio:
        other = studio.frame(studio.capture("right"))
        seen_other = studio.perceive(other.info.frame)
    assert np.abs(np.subtract(frame.q_rad, other.q_rad)).max() < TOUCHED_RAD
    differing = (np.asarray(frame.rgb) != np.asarray(other.rgb)).any(axis=2)
    assert differing.mean() < 0.01
    off_m = np.abs(np.asarray(frame.depth_m) - np.asarray(other.depth_m))
    assert np.quantile(off_m, 0.995) < 1e-4
    assert labels(seen) == labels(seen_other)


def test_every_state_is_recorded_with_the_bodies_under_its_detections() -> None:
    made = generate("covered", 1)
    with Studio(made, CELL, "classical") as studio:
        recorded = studio.record()
    recording, truth = recorded.recording, recorded.truth
    assert [shot.state for shot in recording.shots] == states(True, CELL)
    first, *_ = recording.shots
    after = next(shot for shot in recording.shots if shot.state.cover == "open")
    assert (first.observations.cover, after.observations.cover) == ("covered", "open")
    target = made.truth.target
    assert target not in truth.bodies(first.state).values()
    assert target in truth.bodies(after.state).values()
    names = {body.name for body in made.scene.bodies}
    for shot in recording.shots:
        under = truth.bodies(shot.state)
        assert under.keys() == {one.id for one in shot.observations.detections}
        assert set(under.values()) <= names | {None}


SEGMENTATION = np.array([[0, 0, -5], [1, 0, -5]], np.int16)


@pytest.mark.parametrize(
    ("counts", "body"),
    [
        ((0, 4, 2), "a"),  # both left columns: three pixels of a, one of b
        ((0, 2, 4), None),  # the left column: one of each
        ((0, 6), None),  # everything: a has half, not more
        ((1, 1, 4), "b"),
        ((4, 2), None),  # the table
    ],
)
def test_a_mask_belongs_to_the_body_that_has_its_majority(
    counts: tuple[int, ...], body: str | None
) -> None:
    mask = Mask(height=2, width=3, counts=counts)
    one = msgspec.structs.replace(detection(1, 0), id="d", mask=mask)
    seen = msgspec.structs.replace(observations(1), detections=(one,))
    assert bodies_under(seen, SEGMENTATION, ("a", "b")) == {"d": body}
