"""A stored frame comes back as it was written; every way in which it can be wrong is named."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from surefetch.common.errors import BadInput
from surefetch.common.geometry import look_at
from surefetch.common.rgbd_folder import RgbdFrame, read_frame, write_frame


def a_frame(seed: int = 0, *, pose: bool = True, view: str | None = "center") -> RgbdFrame:
    rng = np.random.default_rng(seed)
    T = look_at(rng.uniform(0.2, 1.0, 3), np.zeros(3), np.array([0.0, 0.0, 1.0]))
    return RgbdFrame(
        rgb=rng.integers(0, 256, (12, 16, 3), dtype=np.uint8),
        depth_m=rng.uniform(0.2, 2.0, (12, 16)).astype(np.float32),
        K=np.array([[20.0, 0.0, 7.5], [0.0, 21.0, 5.5], [0.0, 0.0, 1.0]]),
        T_world_camera=T if pose else None,
        view=view,
    )


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_frame(tmp_path, a_frame())
    return tmp_path


def rewrite(folder: Path, **changes: Any) -> None:
    path = folder / "camera.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.booleans(), st.none() | st.text(min_size=1, max_size=8))
def test_a_frame_comes_back_as_it_was(
    tmp_path_factory: pytest.TempPathFactory, seed: int, pose: bool, view: str | None
) -> None:
    folder, frame = tmp_path_factory.mktemp("frame"), a_frame(seed, pose=pose, view=view)
    write_frame(folder, frame, depth_scale_m=1e-4)
    back = read_frame(folder)
    assert np.array_equal(back.rgb, frame.rgb)
    assert np.abs(back.depth_m - frame.depth_m).max() <= 0.5e-4 + 1e-7
    assert np.array_equal(back.K, frame.K)
    assert back.view == view
    if frame.T_world_camera is None or back.T_world_camera is None:
        assert back.T_world_camera is frame.T_world_camera
    else:
        assert np.array_equal(back.T_world_camera, frame.T_world_camera)


def test_depth_beyond_what_16_bits_hold_is_missing(tmp_path: Path) -> None:
    frame = a_frame()
    frame.depth_m[0, 0] = 7.0
    write_frame(tmp_path, frame, depth_scale_m=1e-4)
    assert read_frame(tmp_path).depth_m[0, 0] == 0.0


def test_transparency_is_dropped(folder: Path) -> None:
    before = read_frame(folder).rgb
    Image.fromarray(before).convert("RGBA").save(folder / "color.png")
    assert np.array_equal(read_frame(folder).rgb, before)


@pytest.mark.parametrize("name", ["camera.json", "color.png", "depth.png"])
def test_a_missing_file_is_named(folder: Path, name: str) -> None:
    (folder / name).unlink()
    with pytest.raises(BadInput, match=f"{name} missing"):
        read_frame(folder)


def test_a_folder_that_is_none_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="none is no folder"):
        read_frame(tmp_path / "none")


@pytest.mark.parametrize("name", ["color.png", "depth.png"])
@pytest.mark.parametrize("keep", [0, 30, 0.7])
def test_a_truncated_picture_is_told(folder: Path, name: str, keep: float) -> None:
    content = (folder / name).read_bytes()
    n_bytes = int(keep * len(content)) if keep < 1 else int(keep)
    (folder / name).write_bytes(content[:n_bytes])
    with pytest.raises(BadInput, match=f"{name} is no readable picture"):
        read_frame(folder)


def test_pictures_of_different_sizes_are_told_with_both(folder: Path) -> None:
    Image.fromarray(np.ones((6, 8), np.uint16)).save(folder / "depth.png")
    with pytest.raises(BadInput, match=r"depth\.png has 8 x 6 pixels, but .* 16 x 12"):
        read_frame(folder)


def test_pictures_of_the_wrong_kind_are_told(folder: Path) -> None:
    grey = Image.fromarray(np.ones((12, 16), np.uint8))
    grey.save(folder / "depth.png")
    with pytest.raises(BadInput, match=r'depth\.png must have 16 bits .* "L"'):
        read_frame(folder)
    grey.save(folder / "color.png")
    with pytest.raises(BadInput, match=r'color\.png must be 8-bit RGB; .* "L"'):
        read_frame(folder)


def test_depth_that_is_all_missing_is_told(folder: Path) -> None:
    Image.fromarray(np.zeros((12, 16), np.uint16)).save(folder / "depth.png")
    with pytest.raises(BadInput, match=r"depth\.png holds no depth"):
        read_frame(folder)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"fx": None}, '"fx" must be a finite number, found None'),
        ({"fx": "20"}, '"fx" must be a finite number'),
        ({"fx": True}, '"fx" must be a finite number'),
        ({"fy": float("nan")}, '"fy" must be a finite number'),
        ({"fy": -1}, '"fy" must be greater than 0'),
        ({"width": 15.5}, '"width" must be a whole number'),
        ({"depth_scale_m": 0}, '"depth_scale_m" must be greater than 0'),
        ({"view": 3}, '"view" must be a word'),
        ({"T_world_camera": [[1, 0], [0, 1]]}, "must be a 4 x 4 rigid transform"),
        ({"T_world_camera": [["a"] * 4] * 4}, "must be a 4 x 4 rigid transform"),
        ({"T_world_camera": (2 * np.eye(4)).tolist()}, "must be a 4 x 4 rigid transform"),
        (
            {"T_world_camera": np.diag([1.0, 1.0, -1.0, 1.0]).tolist()},
            "must be a 4 x 4 rigid transform",
        ),
    ],
)
def test_a_camera_that_makes_no_sense_is_told_by_its_key(
    folder: Path, changes: dict[str, Any], words: str
) -> None:
    rewrite(folder, **changes)
    with pytest.raises(BadInput, match=f"camera.json.*{words}"):
        read_frame(folder)


@pytest.mark.parametrize("text", ["", "[1]", "{", "\udcff", "[" * 100_000])
def test_a_camera_file_that_is_no_object_is_told(folder: Path, text: str) -> None:
    (folder / "camera.json").write_text(text, "utf-8", "surrogateescape")
    with pytest.raises(BadInput, match=r"camera\.json"):
        read_frame(folder)


def test_a_missing_key_is_told_with_those_that_are_needed(folder: Path) -> None:
    camera = json.loads((folder / "camera.json").read_text())
    del camera["cx"]
    (folder / "camera.json").write_text(json.dumps(camera))
    with pytest.raises(BadInput, match='the key "cx" is missing. Needed: width, height, fx'):
        read_frame(folder)
