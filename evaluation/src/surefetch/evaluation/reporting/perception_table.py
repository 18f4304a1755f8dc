"""The perception table from `study perception --json`, beside the paper's figures. Pure."""

from collections.abc import Mapping
from typing import Any, Final

from surefetch.evaluation.reporting import numbers
from surefetch.evaluation.reporting.paper_numbers import PERCEPTION
from surefetch.evaluation.reporting.table import NA, Table

ROWS: Final = {
    "target_recall_5": "candidate Recall@5, of visible targets",
    "object_recall_5": "candidate Recall@5, of all objects",
    "container_f1_uncut": "container F1 at IoU 0.5, whole in the image",
    "container_f1_cut": "container F1 at IoU 0.5, cut by the border",
    "mask_ap_50_95": "mask AP50:95",
    "miou_all": "mask mean IoU, unmatched objects counting 0",
    "miou_matched": "mask mean IoU, of matched objects",
}
SETS: Final = ("usual", "unseen conditions")


def table(told: Mapping[str, Any] | None) -> Table:
    """Figures over all images and of each view."""
    heads: list[str] = []
    parts: list[Mapping[str, Any]] = []
    for name in SETS:
        of: Mapping[str, Any] = (told or {}).get(name, {})
        views = of.get("views", {}) if name == "usual" else {}
        for head, part in {f"{name}, all": of.get("all", {}), **views}.items():
            heads.append(f"ours: {head} ({part.get('images', NA)} images)")
            parts.append(part)
    rows = tuple(
        (label, numbers.percent(PERCEPTION.get(key)), *(_cell(part.get(key)) for part in parts))
        for key, label in ROWS.items()
    )
    backend = NA if told is None else str(told.get("backend", NA))
    notes = (
        "The paper: 150 images of its own, Grounding DINO-Base with SAM 2.1 Hiera-L. Ours are "
        f"renders of our scenes, perceived by {backend}. The images differ, so the columns cannot "
        "be compared as two detectors on one test. Intervals: resampled layouts.",
        "Our renders have no mixed pixels at edges, which makes masks far easier than a camera's: "
        "mask AP and IoU say that the front end is no bottleneck here, not that it is better.",
        "Recall of all objects cannot reach 100 % where a scene shows more than five.",
    )
    return Table("Perception", ("figure", "paper (150 images)", *heads), rows, notes)


def _cell(part: Mapping[str, Any] | None) -> str:
    if part is None or part.get("value") is None:
        return NA
    value = numbers.percent(part["value"])
    low, high = part.get("interval_95", (None, None))
    return value if low is None else f"{value} [{100 * low:.1f}, {100 * high:.1f}]"
