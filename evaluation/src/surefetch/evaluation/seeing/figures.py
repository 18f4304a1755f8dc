"""Scored pictures to the figures of the perception table, each with its interval. Pure."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from surefetch.evaluation.seeing import coco, metrics
from surefetch.evaluation.seeing.coco import Matches
from surefetch.evaluation.seeing.metrics import Counts, Scored

SEED: Final = 0
QUESTIONS: Final = ("color", "shape", "marking", "membership")
LABELS: Final = {
    "membership": ("inside", "outside", "unknown"),
    "identity": ("supported", "contradicted", "unobservable"),
}


def figures(pictures: Sequence[Scored]) -> dict[str, Any]:
    """All figures over all pictures, and over those of each view."""
    judged = coco.matches(pictures)
    views = sorted({picture.view for picture in pictures})
    by_view = {}
    for view in views:
        chosen = [k for k, picture in enumerate(pictures) if picture.view == view]
        by_view[view] = _figures([pictures[k] for k in chosen], [judged[k] for k in chosen])
    return {"all": _figures(pictures, judged), "views": by_view}


def _figures(pictures: Sequence[Scored], judged: Sequence[Matches]) -> dict[str, Any]:
    counts = metrics.count(pictures)
    target, objects = metrics.share(counts.target), metrics.share(counts.objects)
    single = [metrics.count([picture]) for picture in pictures]
    layouts = [picture.layout for picture in pictures]

    def spread(of: Any, items: Sequence[Any]) -> tuple[float | None, float | None]:
        low, high = metrics.interval(layouts, items, of, np.random.default_rng(SEED))
        return _number(low), _number(high)

    return {
        "images": len(pictures),
        "target_recall_5": {"n": target.n, "of": target.of, "value": _number(target.value)}
        | {"interval_95": spread(_target, single)},
        "object_recall_5": {"n": objects.n, "of": objects.of, "value": _number(objects.value)}
        | {"interval_95": spread(_objects, single)},
        "container_f1_uncut": _container(counts.container_uncut)
        | {"interval_95": spread(_uncut, single)},
        "container_f1_cut": _container(counts.container_cut),
        "container_f1_mask": _container(counts.container_mask),
        "mask_ap_50_95": {
            "value": _number(coco.average_precision(judged)),
            "interval_95": spread(coco.average_precision, judged),
        },
        "miou_all": {
            "value": _mean(counts.ious),
            "of": len(counts.ious),
            "interval_95": spread(_ious, single),
        },
        "miou_matched": {"value": _mean(counts.matched_ious), "of": len(counts.matched_ious)},
        "answers": _answers(counts),
    }


def _target(few: Sequence[Counts]) -> float:
    of = sum(one.target.total() for one in few)
    return sum(one.target[True] for one in few) / of if of else float("nan")


def _objects(few: Sequence[Counts]) -> float:
    of = sum(one.objects.total() for one in few)
    return sum(one.objects[True] for one in few) / of if of else float("nan")


def _ious(few: Sequence[Counts]) -> float:
    of = sum(len(one.ious) for one in few)
    return sum(sum(one.ious) for one in few) / of if of else float("nan")


def _uncut(few: Sequence[Counts]) -> float:
    return metrics.f1(sum((one.container_uncut for one in few), Counter()))


def _container(counter: Any) -> dict[str, Any]:
    return {
        "value": _number(metrics.f1(counter)),
        "hit": counter["hit"],
        "false": counter["false"],
        "missed": counter["missed"],
    }


def _answers(counts: Counts) -> dict[str, Any]:
    """Of each question, labels by whether the asked value was true; and the share of wrong ones."""
    out: dict[str, Any] = {}
    for question in QUESTIONS:
        labels = LABELS["membership" if question == "membership" else "identity"]
        rows = {
            name: {label: counts.answers[(question, truth, label)] for label in labels}
            for name, truth in (("true", True), ("false", False))
        }
        asked = sum(sum(row.values()) for row in rows.values())
        wrong = rows["true"][labels[1]] + rows["false"][labels[0]]
        abstained = rows["true"][labels[2]] + rows["false"][labels[2]]
        out[question] = rows | {
            "wrong": wrong / asked if asked else None,
            "abstained": abstained / asked if asked else None,
        }
    return out


def _mean(values: Sequence[float]) -> float | None:
    return float(np.mean(values)) if values else None


def _number(value: float) -> float | None:
    return None if np.isnan(value) else float(value)
