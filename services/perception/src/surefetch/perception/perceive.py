"""`surefetch perceive FOLDER "INSTRUCTION"`: perception alone, on a stored RGB-D frame."""

import argparse
import json
import time
from pathlib import Path
from typing import Any, Final

from PIL import Image

from surefetch.common.errors import BadInput
from surefetch.common.instruction import describe, parse
from surefetch.common.messages import Answer, FrameId, Observations, Target
from surefetch.common.rgbd_folder import read_frame
from surefetch.perception.annotate import annotated
from surefetch.perception.backends import BACKENDS
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.observe import observe
from surefetch.perception.reply import reply

HELP: Final = """\
FOLDER holds color.png (8-bit RGB), depth.png (16-bit, registered) and camera.json with width,
height, fx, fy, cx, cy, depth_scale_m and, if known, T_world_camera. Without a pose the support is
found in the depth and becomes z = 0.

example:
  surefetch perceive frames/7 "the red cylinder inside the box" --out seen --json
"""


def main(argv: list[str]) -> int:
    """Perceive one stored frame. Raises BadInput that names the file or the word."""
    told = _parser().parse_args(argv)
    geometry = LatestGeometry()
    backend = BACKENDS["classical"](geometry)
    target = parse(told.instruction, backend.vocabulary)
    frame = read_frame(told.folder)
    if told.out is not None:
        _check_writable(told.out)
    started = time.perf_counter()
    perceived = observe(frame, target, backend, geometry)
    took_s = time.perf_counter() - started
    seen = reply(perceived, FrameId(boot="stored", counter=1), backend.name, duration_s=took_s)
    found = as_json(seen, target)
    if told.out is not None:
        told.out.mkdir(parents=True, exist_ok=True)
        Image.fromarray(annotated(frame.rgb, seen)).save(told.out / "perceived.png")
        (told.out / "perceived.json").write_text(json.dumps(found, indent=1) + "\n", "utf-8")
    print(json.dumps(found) if told.json else _told(seen, target))
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="surefetch perceive",
        description="Candidates, answers and the container in one stored RGB-D frame.",
        epilog=HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("folder", type=Path, metavar="FOLDER")
    parser.add_argument("instruction", metavar="INSTRUCTION")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write picture and JSON here")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    return parser


def _check_writable(folder: Path) -> None:
    for path in (folder, *folder.parents):
        if path.exists() and not path.is_dir():
            raise BadInput(f"--out {folder}: {path} is a file; name a folder. Nothing was written.")


def as_json(seen: Observations, target: Target) -> dict[str, Any]:
    """What was seen, in plain values; lengths in metres, boxes in pixels."""
    container = seen.container
    return {
        "understood": describe(target),
        "backend": seen.backend,
        "candidates": [
            {
                "box": list(detection.box_px),
                "score": detection.score,
                "group": detection.group,
                "representative": detection.representative,
                "centre_world_m": _list(detection.center_world_m),
                "size_m": None if detection.solid is None else list(detection.solid.size_m),
                "yaw_rad": None if detection.solid is None else detection.solid.yaw_rad,
                "answers": None
                if detection.answers is None
                else {
                    question: _answer(getattr(detection.answers, question))
                    for question in ("color", "shape", "marking", "membership")
                },
            }
            for detection in seen.detections
        ],
        "container": None
        if container is None
        else {
            "box": list(container.box_px),
            "score": container.score,
            "centre_world_m": list(container.outer.center_world_m),
            "size_m": list(container.outer.size_m),
            "inner_size_m": list(container.inner_size_m),
            "yaw_rad": container.outer.yaw_rad,
            "rim_z_m": container.rim_z_m,
            "floor_z_m": container.floor_z_m,
            "complete": container.complete,
        },
        "cover": seen.cover,
        "obstacles": [
            {"centre_world_m": list(box.center_world_m), "size_m": list(box.size_m)}
            for box in seen.obstacles
        ],
        "duration_s": seen.duration_s,
    }


def _list(values: tuple[float, ...] | None) -> list[float] | None:
    return None if values is None else list(values)


def _answer(answer: Answer | None) -> dict[str, Any] | None:
    return None if answer is None else {"label": answer.label, "scores": list(answer.scores)}


def _told(seen: Observations, target: Target) -> str:
    """The same for people."""
    lines = [f"understood: {describe(target)}", f"cover: {seen.cover}"]
    for i, detection in enumerate(seen.detections, start=1):
        where = detection.center_world_m
        at = "no depth" if where is None else f"at x {where[0]:.3f} y {where[1]:.3f} m"
        lines.append(f"{i}. score {detection.score:.2f}, {at}: {_labels(detection.answers)}")
    if not seen.detections:
        lines.append("no candidates")
    return "\n".join(lines)


def _labels(answers: Any) -> str:
    if answers is None:
        return "same as a better one"
    asked = ((question, getattr(answers, question)) for question in answers.__struct_fields__)
    return ", ".join(f"{question} {answer.label}" for question, answer in asked if answer)
