"""`surefetch perceive` on stored frames: good ones, and each way in which one can be bad."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from rendered import Shot, shoot
from tabletop import body, box, scene

from surefetch.common import cli
from surefetch.common.mask import box_iou, box_of
from surefetch.common.rgbd_folder import RgbdFrame, write_frame

SENTENCE = "the red cube inside the box"


@pytest.fixture(scope="module")
def shot() -> Shot:
    inside = body("inside", at_m=(1.0, 0.03))
    outside = body("outside", "cylinder", (0.05, 0.05, 0.07), (0.84, -0.16))
    return shoot(scene(inside, outside, container=box(covered=False)), "close_high")


@pytest.fixture
def folder(shot: Shot, tmp_path: Path) -> Path:
    write_frame(tmp_path / "frame", shot.frame)
    return tmp_path / "frame"


def perceive(*words: str, capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    """The JSON object that a good frame gives."""
    assert cli.main(["perceive", *words, "--json"]) == 0
    told: dict[str, Any] = json.loads(capsys.readouterr().out.splitlines()[-1])
    return told


def test_the_json_says_what_is_where(
    folder: Path, shot: Shot, capsys: pytest.CaptureFixture[str]
) -> None:
    told = perceive(str(folder), SENTENCE, capsys=capsys)
    assert told["understood"] == "a red cube, inside the box"
    assert len(told["candidates"]) == 2
    first = told["candidates"][0]
    assert box_iou(first["box"], box_of(shot.pixels_of(0))) > 0.9
    assert first["centre_world_m"] == pytest.approx([1.0, 0.03, 0.03], abs=0.006)
    assert {name: first["answers"][name]["label"] for name in ("color", "shape", "membership")} == {
        "color": "supported",
        "shape": "supported",
        "membership": "inside",
    }
    assert first["answers"]["marking"] is None
    assert told["container"]["complete"]
    assert told["container"]["centre_world_m"][:2] == pytest.approx([1.02, 0.03], abs=0.003)
    assert told["cover"] == "open"
    _check_finite(told)


def _check_finite(value: object) -> None:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for one in value:
            _check_finite(one)
    assert not isinstance(value, float) or math.isfinite(value)


def test_without_a_pose_the_support_becomes_the_ground(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    camera = json.loads((folder / "camera.json").read_text())
    del camera["T_world_camera"]
    (folder / "camera.json").write_text(json.dumps(camera))
    told = perceive(str(folder), SENTENCE, capsys=capsys)
    bottoms = [c["centre_world_m"][2] - c["size_m"][2] / 2 for c in told["candidates"]]
    assert sorted(bottoms) == pytest.approx([0.0, 0.005], abs=0.003)
    assert [c["answers"]["membership"]["label"] for c in told["candidates"]] == [
        "inside",
        "outside",
    ]


def test_a_picture_and_the_json_are_written_on_request(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    told = perceive(str(folder), SENTENCE, "--out", str(tmp_path / "seen"), capsys=capsys)
    written = json.loads((tmp_path / "seen" / "perceived.json").read_text())
    assert written == told
    picture = np.asarray(Image.open(tmp_path / "seen" / "perceived.png"))
    assert picture.shape == (480, 640, 3)
    assert (picture != np.asarray(Image.open(folder / "color.png"))).any()


def test_people_are_told_in_words(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["perceive", str(folder), SENTENCE]) == 0
    out = capsys.readouterr().out
    assert "understood: a red cube, inside the box" in out
    assert "color supported, shape supported, membership inside" in out


def _truncate(folder: Path) -> None:
    content = (folder / "color.png").read_bytes()
    (folder / "color.png").write_bytes(content[: len(content) // 2])


def _halve_depth(folder: Path) -> None:
    depth = np.asarray(Image.open(folder / "depth.png"))
    Image.fromarray(depth[::2, ::2].astype(np.uint16)).save(folder / "depth.png")


def _no_readings(folder: Path) -> None:
    Image.fromarray(np.zeros((480, 640), np.uint16)).save(folder / "depth.png")


def _wall(folder: Path) -> None:
    Image.fromarray(np.full((480, 640), 8000, np.uint16)).save(folder / "depth.png")
    camera = json.loads((folder / "camera.json").read_text())
    camera["T_world_camera"] = [[0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0.5], [0, 0, 0, 1]]
    (folder / "camera.json").write_text(json.dumps(camera))


BAD: dict[str, tuple[Callable[[Path], object], str]] = {
    "truncated picture": (_truncate, "color.png is no readable picture (truncated?)"),
    "sizes differ": (
        _halve_depth,
        "depth.png has 320 x 240 pixels",
    ),
    "no depth": (lambda folder: (folder / "depth.png").unlink(), "depth.png missing"),
    "depth all zero": (_no_readings, "holds no depth: every pixel is 0"),
    "no camera": (lambda folder: (folder / "camera.json").write_text("[]"), "one JSON object"),
    "only a wall": (_wall, "no support plane is visible"),
}


@pytest.mark.parametrize("kind", sorted(BAD))
def test_a_bad_frame_ends_in_one_sentence_and_writes_nothing(
    kind: str, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spoil, said = BAD[kind]
    spoil(folder)
    words = ["perceive", str(folder), SENTENCE, "--out", str(tmp_path / "seen"), "--json"]
    assert cli.main(words) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert "Traceback" not in err
    assert not (tmp_path / "seen").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("nowhere", SENTENCE), "nowhere is no folder"),
        ((".", SENTENCE), "is no stored frame"),
        (("FRAME", "the red mug"), '"mug" is nothing that this perception'),
        (("FRAME", "the red blue cube"), 'color "red" and "blue"'),
        (("FRAME", ""), "the instruction is empty"),
    ],
)
def test_bad_words_end_in_one_sentence(
    words: tuple[str, str],
    said: str,
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    where = str(folder) if words[0] == "FRAME" else words[0]
    assert cli.main(["perceive", where, words[1], "--json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err


def test_an_out_that_is_a_file_is_refused(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("kept")
    assert cli.main(["perceive", str(folder), SENTENCE, "--out", str(tmp_path / "file")]) == 2
    assert "name a folder" in capsys.readouterr().err
    assert (tmp_path / "file").read_text() == "kept"


def test_half_of_the_depth_missing_still_gives_an_answer(
    shot: Shot, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    depth = shot.frame.depth_m.copy()
    depth[:, :150] = 0
    depth[np.random.default_rng(0).random(depth.shape) < 0.4] = 0
    frame = RgbdFrame(shot.frame.rgb, depth, shot.frame.K, shot.frame.T_world_camera)
    write_frame(tmp_path / "frame", frame)
    told = perceive(str(tmp_path / "frame"), SENTENCE, capsys=capsys)
    assert box_iou(told["candidates"][0]["box"], box_of(shot.pixels_of(0))) > 0.8
    _check_finite(told)
