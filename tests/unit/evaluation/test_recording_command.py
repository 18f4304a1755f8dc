"""`surefetch study record`: records what is missing, once, and mixes nothing."""

import json
from pathlib import Path

import msgspec
import pytest

from surefetch.common import codec
from surefetch.common.errors import BadInput, InfrastructureError
from surefetch.evaluation.recordings import record as study_record
from surefetch.evaluation.recordings import recording_store, repeats
from surefetch.evaluation.recordings.recording import FORMAT, Recording, Repeated
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


def test_reading_loses_nothing_that_was_written(recorded: Path) -> None:
    written = (recorded / "visible-7.recording").read_bytes()
    recording = recording_store.load(recorded, "visible", 7)
    assert codec.encode(recording, max_bytes=recording_store.MAX_BYTES) == written


def timeless(folder: Path) -> bytes:
    """A recording but for how long things took, and for whether it was looked at twice."""
    recording = recording_store.load(folder, "visible", 7)
    shots = [
        msgspec.structs.replace(
            shot, observations=msgspec.structs.replace(shot.observations, duration_s=0.0)
        )
        for shot in recording.shots
    ]
    still: Recording = msgspec.structs.replace(
        recording, shots=tuple(shots), durations_s={}, repeated=None
    )
    return codec.encode(still, max_bytes=recording_store.MAX_BYTES)


def test_a_scene_recorded_again_is_the_same_to_the_byte_and_looked_at_twice_too(
    recorded: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(repeats, "is_repeated", lambda *_: True)
    assert record(tmp_path) == 0
    repeated = recording_store.load(tmp_path, "visible", 7).repeated
    assert repeated is not None
    told = capsys.readouterr().out
    assert "Processor time of a scene" in told
    assert f"1 scenes were looked at twice: 0 of {repeated.candidates} candidates" in told
    assert timeless(tmp_path) == timeless(recorded)
    for name in ("visible-7.pictures", "truth/visible-7.json", "truth/visible-7.scene.json"):
        assert (tmp_path / name).read_bytes() == (recorded / name).read_bytes()


def test_every_state_has_its_picture(recorded: Path) -> None:
    recording = recording_store.load(recorded, "visible", 7)
    pictures = recording_store.load_pictures(recorded, "visible", 7)
    for shot in recording.shots:
        assert pictures.rgb(shot.state).shape == (480, 640, 3)
    with pytest.raises(BadInput, match=r"visible-8\.pictures holds no pictures"):
        recording_store.load_pictures(recorded, "visible", 8)


def test_a_recording_of_another_format_is_refused(recorded: Path, tmp_path: Path) -> None:
    recording = recording_store.load(recorded, "visible", 7)
    truth = recording_store.load_truth(recorded, "visible", 7)
    older = msgspec.structs.replace(recording, format=FORMAT - 1)
    scene = recording_store.load_scene_truth(recorded, "visible", 7)
    recording_store.save(tmp_path, older, truth, scene)
    with pytest.raises(BadInput, match=f"has format {FORMAT - 1}; this version reads {FORMAT}"):
        recording_store.load(tmp_path, "visible", 7)


def test_recording_ends_where_a_second_look_shows_something_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def done(job: study_record.Job) -> study_record.Done:
        return study_record.Done("visible:7", {}, Repeated(candidates=10, differing=1))

    monkeypatch.setattr(study_record, "record_one", done)
    with pytest.raises(InfrastructureError, match="1 of 10 candidates"):
        record(tmp_path)


def test_what_is_recorded_is_not_recorded_again(
    recorded: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(job: study_record.Job) -> study_record.Done:
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
