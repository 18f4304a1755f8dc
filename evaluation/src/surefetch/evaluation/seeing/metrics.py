"""What perception found in a picture against what is there, counted as the table prints it. Pure.

Objects with fewer than 100 visible pixels count for nothing. Boxes are of visible pixels,
x0, y0, x1, y1 in pixels, the far edges exclusive.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

LEAST_PX: Final = 100
TOP: Final = 5
SAME_IOU: Final = 0.5
VISIBLE_SHARE: Final = 0.1
FRAME_PX: Final = 2
RESAMPLES: Final = 2000

Bits = NDArray[np.bool_]
Box = tuple[float, float, float, float]
Asked = tuple[str, bool, str]
"""Question, whether the asked value is true, and the answer's label"""


@dataclass(frozen=True, eq=False)
class Found:
    """One detection, or one object in truth."""

    box: Box
    mask: Bits
    """(h, w)"""
    score: float = 1.0


@dataclass(frozen=True, eq=False)
class Scored:
    """One picture: what was found, what is there."""

    layout: str
    view: str
    shape: tuple[int, int]
    """Height and width"""
    detections: tuple[Found, ...]
    """One of each group, best score first"""
    objects: tuple[Found, ...]
    """With at least 100 visible pixels"""
    ignored: tuple[Bits, ...]
    """Masks of what may be found or not: smaller objects, screens"""
    target: Box | None
    """None where no target is visible"""
    container: Found | None
    """As found"""
    true_container: Found | None
    answers: tuple[Asked, ...] = ()


@dataclass(frozen=True)
class Share:
    """A count out of a number."""

    n: int
    of: int

    @property
    def value(self) -> float:
        """The share; nan of nothing."""
        return self.n / self.of if self.of else float("nan")


@dataclass
class Counts:
    """What can be added over pictures."""

    target: Counter[bool] = field(default_factory=Counter)
    objects: Counter[bool] = field(default_factory=Counter)
    container_uncut: Counter[str] = field(default_factory=Counter)
    container_cut: Counter[str] = field(default_factory=Counter)
    container_mask: Counter[str] = field(default_factory=Counter)
    ious: list[float] = field(default_factory=list)
    """Of every object, 0 for the unmatched"""
    matched_ious: list[float] = field(default_factory=list)
    answers: Counter[Asked] = field(default_factory=Counter)


def box_of(bits: Bits) -> Box:
    """The box of a mask's pixels; all 0 for none."""
    rows, columns = np.flatnonzero(bits.any(1)), np.flatnonzero(bits.any(0))
    if not len(rows):
        return (0.0, 0.0, 0.0, 0.0)
    return (float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1))


def box_iou(a: Box, b: Box) -> float:
    """Intersection over union."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    both = max(0.0, width) * max(0.0, height)
    union = (a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - both
    return both / union if union > 0.0 else 0.0


def mask_iou(a: Bits, b: Bits) -> float:
    """Intersection over union; 0 of two empty masks."""
    union = int(np.count_nonzero(a | b))
    return int(np.count_nonzero(a & b)) / union if union else 0.0


def matched(detections: Sequence[Found], objects: Sequence[Found]) -> dict[int, int]:
    """Object to detection, one to one: each detection in order takes its best free object."""
    taken: dict[int, int] = {}
    for d, detection in enumerate(detections):
        free = [
            (box_iou(detection.box, one.box), o) for o, one in enumerate(objects) if o not in taken
        ]
        overlap, o = max(free, key=lambda pair: pair[0], default=(0.0, -1))
        if overlap >= SAME_IOU:
            taken[o] = d
    return taken


def count(pictures: Sequence[Scored]) -> Counts:
    """Add pictures up."""
    counts = Counts()
    for picture in pictures:
        _count_objects(picture, counts)
        _count_container(picture, counts)
        counts.answers.update(picture.answers)
    return counts


def _count_objects(picture: Scored, counts: Counts) -> None:
    top = picture.detections[:TOP]
    if picture.target is not None:
        counts.target[any(box_iou(one.box, picture.target) >= SAME_IOU for one in top)] += 1
    recalled = matched(top, picture.objects)
    counts.objects.update(o in recalled for o in range(len(picture.objects)))
    pairs = matched(picture.detections, picture.objects)
    for o, one in enumerate(picture.objects):
        overlap = mask_iou(picture.detections[pairs[o]].mask, one.mask) if o in pairs else 0.0
        counts.ious.append(overlap)
        if o in pairs:
            counts.matched_ious.append(overlap)


def _count_container(picture: Scored, counts: Counts) -> None:
    true, found = picture.true_container, picture.container
    cut = true is not None and is_cut(true.mask)
    boxes = counts.container_cut if cut else counts.container_uncut
    for counter, same in (
        (boxes, _same_boxes(found, true)),
        (counts.container_mask, _same_masks(found, true)),
    ):
        if same:
            counter["hit"] += 1
            continue
        counter["false"] += found is not None
        counter["missed"] += true is not None


def _same_boxes(a: Found | None, b: Found | None) -> bool:
    return a is not None and b is not None and box_iou(a.box, b.box) >= SAME_IOU


def _same_masks(a: Found | None, b: Found | None) -> bool:
    return a is not None and b is not None and mask_iou(a.mask, b.mask) >= SAME_IOU


def is_cut(bits: Bits) -> bool:
    """Whether the image's border cuts a thing: it has pixels in the outermost two."""
    inner = bits[FRAME_PX:-FRAME_PX, FRAME_PX:-FRAME_PX]
    return int(np.count_nonzero(bits)) != int(np.count_nonzero(inner))


def share(counter: Counter[bool]) -> Share:
    """Of what was counted, what was true."""
    return Share(counter[True], counter.total())


def f1(counter: Counter[str]) -> float:
    """2 TP / (2 TP + FP + FN); nan where there is nothing to find and nothing found."""
    hit = 2 * counter["hit"]
    whole = hit + counter["false"] + counter["missed"]
    return hit / whole if whole else float("nan")


T = TypeVar("T")


def interval(
    layouts: Sequence[str],
    items: Sequence[T],
    of: Callable[[Sequence[T]], float],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> tuple[float, float]:
    """2.5 and 97.5 % of a figure over resampled layouts: pictures of one layout go together.

    Source: Efron and Tibshirani, An Introduction to the Bootstrap (1993), section 13.3.
    """
    names = sorted(set(layouts))
    groups = [[k for k, name in enumerate(layouts) if name == one] for one in names]
    values: list[float] = []
    for _ in range(resamples):
        drawn = rng.integers(0, len(groups), len(groups))
        values.append(of([items[k] for g in drawn for k in groups[g]]))
    known = [value for value in values if not np.isnan(value)]
    if not known:
        return float("nan"), float("nan")
    low, high = np.percentile(known, [2.5, 97.5])
    return float(low), float(high)
