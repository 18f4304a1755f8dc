"""Average precision of masks, by COCO's own library (the extra `coco`)."""

import contextlib
import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pycocotools import mask
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

from surefetch.common.geometry import Array
from surefetch.evaluation.seeing.metrics import Bits, Scored, box_of

RECALLS: Final = np.linspace(0.0, 1.0, 101)
N_IOUS: Final = 10
"""0.50, 0.55 … 0.95"""


@dataclass(frozen=True, eq=False)
class Matches:
    """One picture's detections by falling score, as COCO's matching judged them. n detections."""

    scores: Array
    """(n,)"""
    hits: NDArray[np.bool_]
    """(10, n)"""
    ignored: NDArray[np.bool_]
    """(10, n)"""
    n_objects: int


def matches(pictures: Sequence[Scored]) -> list[Matches]:
    """Match every picture's detections with its objects, class-agnostic."""
    judge = _judged(pictures)
    if judge is None:
        return [_nothing(picture) for picture in pictures]
    judged = {one["image_id"]: one for one in judge.evalImgs if one is not None}
    return [
        _matches(judged[k]) if k in judged else _nothing(picture)
        for k, picture in enumerate(pictures)
    ]


def library_average_precision(pictures: Sequence[Scored]) -> float:
    """AP50:95 by the library from beginning to end; nan without objects."""
    judge = _judged(pictures)
    if judge is None:
        return 0.0 if any(picture.objects for picture in pictures) else float("nan")
    with contextlib.redirect_stdout(io.StringIO()):
        judge.accumulate()
    value = float(judge.eval["precision"].mean())
    return float("nan") if value < 0.0 else value


def _judged(pictures: Sequence[Scored]) -> Any | None:
    found = _found(pictures)
    if not found:
        return None
    with contextlib.redirect_stdout(io.StringIO()):
        truth = COCO()
        truth.dataset = _truth(pictures)
        truth.createIndex()
        judge = COCOeval(truth, truth.loadRes(found), "segm")
        judge.params.areaRng, judge.params.areaRngLbl = [[0, 1e10]], ["all"]
        judge.params.maxDets = [100]
        judge.evaluate()
    return judge


def average_precision(judged: Sequence[Matches]) -> float:
    """AP50:95 with 101 recalls; nan without objects.

    Source: pycocotools, cocoeval.py, accumulate.
    """
    n_objects = sum(one.n_objects for one in judged)
    if n_objects == 0:
        return float("nan")
    order = np.argsort(-np.concatenate([one.scores for one in judged]), kind="mergesort")
    hits = np.concatenate([one.hits for one in judged], axis=1)[:, order]
    counted = ~np.concatenate([one.ignored for one in judged], axis=1)[:, order]
    values = [_one_iou(hit[count], n_objects) for hit, count in zip(hits, counted, strict=True)]
    return float(np.mean(values))


def _one_iou(hits: NDArray[np.bool_], n_objects: int) -> float:
    right = np.cumsum(hits)
    precision = right / np.arange(1, len(hits) + 1)
    best = np.append(np.maximum.accumulate(precision[::-1])[::-1], 0.0)
    at = np.searchsorted(right / n_objects, RECALLS, side="left")
    return float(best[at].mean())


def _nothing(picture: Scored) -> Matches:
    none = np.zeros((N_IOUS, 0), dtype=np.bool_)
    return Matches(np.zeros(0), none, none, len(picture.objects))


def _matches(one: dict[str, Any]) -> Matches:
    ignored = np.asarray(one["gtIgnore"], dtype=np.bool_)
    return Matches(
        np.asarray(one["dtScores"], dtype=np.float64),
        np.asarray(one["dtMatches"]) > 0,
        np.asarray(one["dtIgnore"], dtype=np.bool_),
        int(np.count_nonzero(~ignored)),
    )


def _truth(pictures: Sequence[Scored]) -> dict[str, Any]:
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    for k, picture in enumerate(pictures):
        height, width = picture.shape
        images.append({"id": k, "height": height, "width": width})
        wanted = [(one.mask, 0) for one in picture.objects]
        for bits, crowd in [*wanted, *((bits, 1) for bits in picture.ignored)]:
            annotations.append(
                {"id": len(annotations) + 1, "image_id": k, "category_id": 1, "iscrowd": crowd}
                | _shape(bits)
            )
    return {"images": images, "annotations": annotations, "categories": [{"id": 1}], "info": {}}


def _found(pictures: Sequence[Scored]) -> list[dict[str, Any]]:
    return [
        {"image_id": k, "category_id": 1, "score": one.score} | _shape(one.mask)
        for k, picture in enumerate(pictures)
        for one in picture.detections
    ]


def _shape(bits: Bits) -> dict[str, Any]:
    x0, y0, x1, y1 = box_of(bits)
    return {
        "segmentation": mask.encode(np.asfortranarray(bits.astype(np.uint8))),
        "area": int(np.count_nonzero(bits)),
        "bbox": [x0, y0, x1 - x0, y1 - y0],
    }
