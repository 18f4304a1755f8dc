"""One stored RGB-D frame as a folder: `color.png`, `depth.png`, `camera.json`.

Everything a reader can get wrong about such a folder is told in one sentence that names the file.
"""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from surefetch.common.errors import BadInput

MAX_PIXELS: Final = 16_000_000
_NUMBERS: Final = ("width", "height", "fx", "fy", "cx", "cy", "depth_scale_m")


@dataclass(frozen=True, eq=False)
class RgbdFrame:
    """Registered colour and depth, with the camera's intrinsics and, if known, its pose."""

    rgb: NDArray[np.uint8]
    """(h, w, 3)"""
    depth_m: NDArray[np.float32]
    """(h, w), along the optical axis; 0 where missing"""
    K: NDArray[np.float64]
    """(3, 3), pixels"""
    T_world_camera: NDArray[np.float64] | None
    """(4, 4), OpenCV axes"""
    view: str | None = None


def read_frame(folder: Path) -> RgbdFrame:
    """Read and check a stored frame.

    Raises:
        BadInput: what is wrong, with which file, and what was expected.
    """
    if not folder.is_dir():
        raise BadInput(f"{folder} is no folder. A stored frame is a folder that holds {_FILES}.")
    missing = [n for n in ("camera.json", "color.png", "depth.png") if not (folder / n).is_file()]
    if missing:
        raise BadInput(
            f"{folder} is no stored frame: {' and '.join(missing)} missing. It must hold {_FILES}."
        )
    camera = _read_camera(folder / "camera.json")
    size = (int(camera["width"]), int(camera["height"]))
    rgb = _read_color(folder / "color.png", size)
    units = _read_depth(folder / "depth.png", size)
    K = np.array(
        [[camera["fx"], 0.0, camera["cx"]], [0.0, camera["fy"], camera["cy"]], [0.0, 0.0, 1.0]]
    )
    depth_m = (units * camera["depth_scale_m"]).astype(np.float32)
    return RgbdFrame(rgb, depth_m, K, camera["T_world_camera"], camera["view"])


_FILES: Final = "color.png (8-bit RGB), depth.png (16-bit) and camera.json"


def write_frame(folder: Path, frame: RgbdFrame, *, depth_scale_m: float = 1e-4) -> None:
    """Write a frame as a folder; the depth is rounded to the scale, too far becomes missing."""
    folder.mkdir(parents=True, exist_ok=True)
    units = np.rint(frame.depth_m / depth_scale_m)
    depth = np.where((units >= 0) & (units <= 65535), units, 0).astype(np.uint16)
    Image.fromarray(frame.rgb).save(folder / "color.png")
    Image.fromarray(depth).save(folder / "depth.png")
    camera: dict[str, Any] = {
        "width": frame.rgb.shape[1],
        "height": frame.rgb.shape[0],
        "fx": float(frame.K[0, 0]),
        "fy": float(frame.K[1, 1]),
        "cx": float(frame.K[0, 2]),
        "cy": float(frame.K[1, 2]),
        "depth_scale_m": depth_scale_m,
    }
    if frame.T_world_camera is not None:
        camera["T_world_camera"] = frame.T_world_camera.tolist()
    if frame.view is not None:
        camera["view"] = frame.view
    (folder / "camera.json").write_text(json.dumps(camera, indent=1) + "\n", encoding="utf-8")


def _read_camera(path: Path) -> dict[str, Any]:
    try:
        camera = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, ValueError, RecursionError) as error:
        raise BadInput(f"{path} is no readable JSON: {error}") from None
    if not isinstance(camera, dict):
        raise BadInput(f"{path} must hold one JSON object with {', '.join(_NUMBERS)}.")
    for key in _NUMBERS:
        if key not in camera:
            raise BadInput(f'{path}: the key "{key}" is missing. Needed: {", ".join(_NUMBERS)}.')
        if not _is_number(camera[key]):
            raise BadInput(f'{path}: "{key}" must be a finite number, found {camera[key]!r}.')
    for key in ("width", "height", "fx", "fy", "depth_scale_m"):
        if camera[key] <= 0:
            raise BadInput(f'{path}: "{key}" must be greater than 0, found {camera[key]}.')
    for key in ("width", "height"):
        if camera[key] != int(camera[key]):
            raise BadInput(f'{path}: "{key}" must be a whole number, found {camera[key]}.')
    view = camera.get("view")
    if view is not None and not isinstance(view, str):
        raise BadInput(f'{path}: "view" must be a word, found {view!r}.')
    return camera | {"T_world_camera": _pose(path, camera.get("T_world_camera")), "view": view}


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def _pose(path: Path, rows: object) -> NDArray[np.float64] | None:
    if rows is None:
        return None
    try:
        T = np.array(rows, dtype=np.float64)
    except (TypeError, ValueError):
        T = np.zeros(0)
    rigid = (
        T.shape == (4, 4)
        and bool(np.isfinite(T).all())
        and np.allclose(T[3], [0, 0, 0, 1], atol=1e-6)
        and np.allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-3)
        and np.linalg.det(T[:3, :3]) > 0
    )
    if not rigid:
        raise BadInput(
            f'{path}: "T_world_camera" must be a 4 x 4 rigid transform in metres (rotation, '
            "translation, last row 0 0 0 1). Leave it out when the pose is not known."
        )
    return T


def _load(path: Path) -> Image.Image:
    """The picture, read to its end."""
    try:
        with Image.open(path) as image:
            if image.size[0] * image.size[1] > MAX_PIXELS:
                raise BadInput(
                    f"{path} has {image.size[0]} x {image.size[1]} pixels; "
                    f"at most {MAX_PIXELS} are read."
                )
            image.load()
            return image
    except BadInput:
        raise
    except Exception as error:  # a broken file makes Pillow raise errors of many kinds
        raise BadInput(f"{path} is no readable picture (truncated?): {error}") from None


def _check_size(path: Path, image: Image.Image, size: tuple[int, int]) -> None:
    if image.size != size:
        raise BadInput(
            f"{path} has {image.size[0]} x {image.size[1]} pixels, but camera.json says "
            f"{size[0]} x {size[1]}. Colour, depth and camera must agree (registered images)."
        )


def _read_color(path: Path, size: tuple[int, int]) -> NDArray[np.uint8]:
    image = _load(path)
    if image.mode not in ("RGB", "RGBA"):
        raise BadInput(f'{path} must be 8-bit RGB; it has the mode "{image.mode}".')
    _check_size(path, image, size)
    return np.asarray(image.convert("RGB"), dtype=np.uint8)


def _read_depth(path: Path, size: tuple[int, int]) -> NDArray[np.float64]:
    image = _load(path)
    if image.mode not in ("I;16", "I;16B", "I;16L", "I"):
        raise BadInput(
            f'{path} must have 16 bits per pixel, one channel; it has the mode "{image.mode}".'
        )
    _check_size(path, image, size)
    units = np.asarray(image, dtype=np.float64)
    if not units.any():
        raise BadInput(f"{path} holds no depth: every pixel is 0 (missing).")
    return units
