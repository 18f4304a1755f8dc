"""`surefetch study record`: records what is missing, once, and mixes nothing."""

import json
from pathlib import Path

import pytest

from surefetch.common.errors import BadInput
from surefetch.evaluation.recordings import record as study_record
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.scenes.generate import generate


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recordings")
    assert record(folder) == 0
    return folder


def record(folder: Path, seeds: str = "7:8") -> int:
    return study_record.main(["--seeds", seeds, "--families", "visible", "--out", str(folder)])


def test_a_recording_is_read_back_with_both_truths(recorded: Path) -> None:
    assert recording_store.scenes(recorded) == [("visible", 7)]
    recording = recording_store.load(recorded, "visible", 7)
    assert recording.sentence == generate("visible", 7).sentence
    truth = recording_store.load_truth(recorded, "visible", 7)
    assert [shot.state for shot in truth.shots] == [shot.state for shot in recording.shots]
    assert recording_store.load_scene_truth(recorded, "visible", 7).target == truth.target


def test_what_is_recorded_is_not_recorded_again(
    recorded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(job: study_record.Job) -> str:
        raise AssertionError(job)

    monkeypatch.setattr(study_record, "record_one", never)
    assert record(recorded) == 0
    with pytest.raises(AssertionError):
        record(recorded, "7:9")


def test_recordings_of_another_generator_are_not_mixed_in(recorded: Path, tmp_path: Path) -> None:
    manifest = json.loads((recorded / "manifest.json").read_text(encoding="utf-8"))
    older = manifest | {"generator_version": manifest["generator_version"] - 1}
    (tmp_path / "manifest.json").write_text(json.dumps(older), encoding="utf-8")
    with pytest.raises(BadInput, match="Name another folder"):
        record(tmp_path)


def test_a_damaged_recording_is_named(recorded: Path, tmp_path: Path) -> None:
    for path in recorded.glob("*.recording"):
        (tmp_path / path.name).write_bytes(path.read_bytes()[:-100])
    with pytest.raises(BadInput, match=r"visible-7\.recording is no readable recording"):
        recording_store.load(tmp_path, "visible", 7)


@pytest.mark.parametrize(
    "words",
    [["--out", "x"], ["--seeds", "1:2", "--split", "development", "--out", "x"]],
)
def test_scenes_must_be_named_one_way(words: list[str]) -> None:
    with pytest.raises(BadInput, match="--split S --episodes N"):
        study_record.main(words)
