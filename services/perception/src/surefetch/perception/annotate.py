"""Draw what was seen on the picture it was seen in. Pure."""

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common import mask
from surefetch.common.messages import Detection, Observations

PALETTE: Final = (
    (0, 114, 178),
    (230, 159, 0),
    (0, 158, 115),
    (204, 121, 167),
    (86, 180, 233),
    (213, 94, 0),
    (240, 228, 66),
)
"""Source: Okabe and Ito, Color universal design (2008)."""
CONTAINER: Final = (255, 255, 255)
_LETTERS: Final = {
    "supported": "+",
    "contradicted": "-",
    "unobservable": "?",
    "inside": "in",
    "outside": "out",
    "unknown": "in?",
}


def annotated(rgb: NDArray[np.uint8], seen: Observations) -> NDArray[np.uint8]:
    """A copy of the picture (h, w, 3) with masks, boxes, answers and the container."""
    out = rgb.copy()
    if seen.container is not None:
        _outline(out, mask.decode(seen.container.mask), CONTAINER)
        label = f"container, {seen.cover}" + ("" if seen.container.complete else ", cut")
        _write(out, label, seen.container.box_px, CONTAINER)
    for i, detection in enumerate(seen.detections):
        color = PALETTE[i % len(PALETTE)]
        _outline(out, mask.decode(detection.mask), color)
        _write(out, f"{i + 1} {_answers(detection)}", detection.box_px, color)
    return out


def _outline(out: NDArray[np.uint8], bits: mask.Bits, color: tuple[int, int, int]) -> None:
    contours, _ = cv2.findContours(bits.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(out, contours, -1, color, max(1, out.shape[0] // 400))


def _write(
    out: NDArray[np.uint8],
    text: str,
    box_px: tuple[float, float, float, float],
    color: tuple[int, int, int],
) -> None:
    scale = max(0.35, out.shape[0] / 1100)
    at = (int(box_px[0]), max(10, int(box_px[1]) - 4))
    for ink, width in (((0, 0, 0), 3), (color, 1)):
        cv2.putText(out, text, at, cv2.FONT_HERSHEY_SIMPLEX, scale, ink, width, cv2.LINE_AA)


def _answers(detection: Detection) -> str:
    answers = detection.answers
    if answers is None:
        return ""
    identity = [a for a in (answers.color, answers.shape, answers.marking) if a is not None]
    return "".join(_LETTERS[a.label] for a in identity) + " " + _LETTERS[answers.membership.label]
