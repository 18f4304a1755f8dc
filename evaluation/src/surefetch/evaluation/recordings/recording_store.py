"""Recordings on disk: ``DIR/FAMILY-SEED.recording``, and the scorer's own under ``DIR/truth/``.

``DIR/FAMILY-SEED.pictures`` is beside it, for figures.

``truth/FAMILY-SEED.json`` says which body lies under each detection, ``.scene.json`` what is true
of the scene, `.measured.json` what came of removing its cover and grasping its target.

A scene counts as recorded when its `.recording` is there, because that file is written last.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Final, TypeVar

import msgspec

from surefetch.common import codec
from surefetch.common.errors import BadInput, CodecError
from surefetch.evaluation.recordings import measured as measured_outcomes
from surefetch.evaluation.recordings.measured import Measured
from surefetch.evaluation.recordings.pictures import Pictures
from surefetch.evaluation.recordings.recording import FORMAT, Recording, RecordingTruth
from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.scenes.truth import SceneTruth

T = TypeVar("T")

MAX_BYTES: Final = 512 * 1024 * 1024
SUFFIX: Final = ".recording"
PICTURES: Final = ".pictures"


def save(
    folder: Path, recording: Recording, truth: RecordingTruth, scene_truth: SceneTruth
) -> None:
    """Write the three files of a scene; a crash in between leaves the scene unrecorded."""
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    stem = _stem(recording.family, recording.seed)
    _write(folder / "truth" / f"{stem}.scene.json", msgspec.json.encode(scene_truth))
    _write(folder / "truth" / f"{stem}.json", msgspec.json.encode(truth))
    _write(folder / f"{stem}{SUFFIX}", codec.encode(recording, max_bytes=MAX_BYTES))


def save_pictures(folder: Path, pictures: Pictures) -> None:
    """Write what the camera showed of a scene."""
    folder.mkdir(parents=True, exist_ok=True)
    encoded = codec.encode(pictures, max_bytes=MAX_BYTES)
    _write(folder / f"{_stem(pictures.family, pictures.seed)}{PICTURES}", encoded)


def is_recorded(folder: Path, family: str, seed: int) -> bool:
    """Whether this scene needs no recording any more."""
    return (folder / f"{_stem(family, seed)}{SUFFIX}").exists()


def scenes(folder: Path) -> list[tuple[str, int]]:
    """Families and seeds of all recorded scenes, families interleaved.

    Raises:
        BadInput: the folder holds no recording.
    """
    if not folder.is_dir():
        raise BadInput(f"{folder} is no folder with recordings.")
    found = [_scene(path) for path in folder.glob(f"*{SUFFIX}")]
    if not found:
        raise BadInput(
            f"{folder} holds no recordings.\n"
            f"  Make some: surefetch study record --split development --episodes N --out {folder}"
        )
    return sorted(found, key=lambda scene: (scene[1], FAMILIES.index(scene[0])))


def load(folder: Path, family: str, seed: int) -> Recording:
    """One recording. Raises BadInput naming a file that is damaged or of another format."""
    path = folder / f"{_stem(family, seed)}{SUFFIX}"
    try:
        recording = codec.decode(path.read_bytes(), Recording, max_bytes=MAX_BYTES)
    except (CodecError, OSError) as error:
        raise BadInput(f"{path} is no readable recording: {error}\n  Record it again.") from None
    if recording.format != FORMAT:
        raise BadInput(
            f"{path} has format {recording.format}; this version reads {FORMAT}. Record it again."
        )
    return recording


def load_pictures(folder: Path, family: str, seed: int) -> Pictures:
    """What the camera showed of a scene. Raises BadInput when it is missing or damaged."""
    path = folder / f"{_stem(family, seed)}{PICTURES}"
    try:
        return codec.decode(path.read_bytes(), Pictures, max_bytes=MAX_BYTES)
    except (CodecError, OSError) as error:
        raise BadInput(f"{path} holds no pictures: {error}\n  Record it again.") from None


def load_truth(folder: Path, family: str, seed: int) -> RecordingTruth:
    """The scorer's file of one recording. Raises BadInput when it is missing or damaged."""
    return _read_truth(folder / "truth" / f"{_stem(family, seed)}.json", RecordingTruth)


def save_measured(folder: Path, measured: Measured) -> None:
    """Write what was measured of a scene beside its truth."""
    (folder / "truth").mkdir(parents=True, exist_ok=True)
    _write(_measured(folder, measured.family, measured.seed), msgspec.json.encode(measured))


def is_measured(folder: Path, family: str, seed: int) -> bool:
    """Whether outcomes of this scene were measured."""
    return _measured(folder, family, seed).exists()


def load_measured(folder: Path, family: str, seed: int) -> Measured:
    """The measured outcomes of a scene.

    Raises:
        BadInput: they were not measured, or are damaged or of another format.
    """
    path = _measured(folder, family, seed)
    if not path.exists():
        raise BadInput(
            f"outcomes of {family}:{seed} were not measured.\n"
            f"  Measure them: surefetch study measure --recordings {folder}"
        )
    measured = _read_truth(path, Measured)
    if measured.format != measured_outcomes.FORMAT:
        raise BadInput(
            f"{path} has format {measured.format}; this version reads "
            f"{measured_outcomes.FORMAT}. Measure it again."
        )
    return measured


def load_scene_truth(folder: Path, family: str, seed: int) -> SceneTruth:
    """What is true of a recorded scene itself. Raises BadInput when it is missing or damaged."""
    return _read_truth(folder / "truth" / f"{_stem(family, seed)}.scene.json", SceneTruth)


def _read_truth(path: Path, kind: type[T]) -> T:
    try:
        return msgspec.json.decode(path.read_bytes(), type=kind)
    except (OSError, msgspec.DecodeError) as error:
        raise BadInput(f"{path} is no readable truth: {error}\n  Record it again.") from None


def load_all(folder: Path) -> Iterator[tuple[Recording, RecordingTruth]]:
    """All recordings with their truths, families interleaved."""
    for family, seed in scenes(folder):
        yield load(folder, family, seed), load_truth(folder, family, seed)


def write_manifest(folder: Path, made_with: dict[str, object]) -> None:
    """Say once what the recordings of a folder were made with.

    Raises:
        BadInput: the folder holds recordings made with something else.
    """
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "manifest.json"
    if path.exists():
        earlier = json.loads(path.read_text(encoding="utf-8"))
        if earlier != made_with:
            raise BadInput(
                f"{folder} holds recordings made with {earlier}; these would be made with "
                f"{made_with}.\n  Name another folder."
            )
        return
    _write(path, json.dumps(made_with, indent=1).encode())


def _scene(path: Path) -> tuple[str, int]:
    family, _, seed = path.name.removesuffix(SUFFIX).rpartition("-")
    if family not in FAMILIES or not seed.isdigit():
        raise BadInput(f"{path}: a recording is named FAMILY-SEED{SUFFIX}.")
    return family, int(seed)


def _measured(folder: Path, family: str, seed: int) -> Path:
    return folder / "truth" / f"{_stem(family, seed)}.measured.json"


def _stem(family: str, seed: int) -> str:
    return f"{family}-{seed}"


def _write(path: Path, content: bytes) -> None:
    """All or nothing, also when the machine stops in between."""
    partial = path.with_suffix(".partial")
    partial.write_bytes(content)
    partial.replace(path)
