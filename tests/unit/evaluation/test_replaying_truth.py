"""No policy learns the truth from what it is told."""

import msgspec
import numpy as np
import pytest
from recorded_table import body, record
from replayed_table import NEVER_FAILS, TABLES, Spy, evaluated, replayed

from surefetch.common.messages import Observations
from surefetch.evaluation.policies.registry import POLICIES
from surefetch.evaluation.recordings.free_space import FREE, SHAPE, UNSEEN, FreeSpace
from surefetch.evaluation.recordings.recording import Recording, RecordingTruth


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


def test_a_policy_is_not_told_the_family_the_seed_or_a_body() -> None:
    spy = Spy()
    replayed(spy, record(TABLES["it must be looked at"], wanted=0, seed=123_456))
    assert len(spy.told) == 3
    for now in spy.told:
        told = repr((now.target, now.believed, now.feasibility, now.used, now.cover, now.estimate))
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
