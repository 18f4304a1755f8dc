"""Binary images as run lengths, and how much two of them overlap. Pure.

Arrays are (h, w) bool. Run lengths are uncompressed COCO: column by column, background first.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from surefetch.common.messages import Mask

Bits = NDArray[np.bool_]


def encode(bits: Bits) -> Mask:
    """Run lengths of a binary image."""
    flat = np.asfortranarray(bits).ravel(order="F")
    changes = np.flatnonzero(flat[1:] != flat[:-1]) + 1
    edges = np.concatenate([[0], changes, [flat.size]])
    counts = np.diff(edges)
    if flat.size and flat[0]:
        counts = np.concatenate([[0], counts])
    return Mask(height=bits.shape[0], width=bits.shape[1], counts=tuple(counts.tolist()))


def decode(mask: Mask) -> Bits:
    """The binary image of run lengths.

    Raises:
        ValueError: the runs do not add up to the image.
    """
    counts = np.asarray(mask.counts, dtype=np.int64)
    if (counts < 0).any() or counts.sum() != mask.height * mask.width:
        raise ValueError(
            f"mask: runs add up to {counts.sum()}, an image of {mask.width} x {mask.height} "
            f"has {mask.height * mask.width} pixels"
        )
    flat = np.repeat(np.arange(len(counts)) % 2 == 1, counts)
    return np.ascontiguousarray(flat.reshape(mask.width, mask.height).T)


def iou(a: Bits, b: Bits) -> float:
    """Intersection over union; 0 for two empty masks."""
    union = int(np.count_nonzero(a | b))
    return int(np.count_nonzero(a & b)) / union if union else 0.0


def iou_matrix(masks: Sequence[Bits], others: Sequence[Bits]) -> NDArray[np.float64]:
    """(len(masks), len(others)) of IoU, by one matrix product."""
    if not masks or not others:
        return np.zeros((len(masks), len(others)))
    a = np.stack([m.ravel() for m in masks]).astype(np.float32)
    b = np.stack([m.ravel() for m in others]).astype(np.float32)
    both = a @ b.T
    union = a.sum(1)[:, None] + b.sum(1)[None, :] - both
    return np.asarray(both / np.maximum(union, 1.0), dtype=np.float64)


def box_of(bits: Bits) -> tuple[float, float, float, float]:
    """x0, y0, x1, y1 in pixels, the far edges exclusive; all 0 for an empty mask."""
    rows, columns = np.flatnonzero(bits.any(1)), np.flatnonzero(bits.any(0))
    if not len(rows):
        return (0.0, 0.0, 0.0, 0.0)
    return (float(columns[0]), float(rows[0]), float(columns[-1] + 1), float(rows[-1] + 1))


def window(masks: Sequence[Bits], margin_px: int) -> tuple[slice, slice]:
    """Rows and columns that hold all pixels of the masks, with a margin; for cropping."""
    x0, y0, x1, y1 = box_of(np.any(masks, axis=0))
    rows = slice(max(0, int(y0) - margin_px), int(y1) + margin_px)
    return rows, slice(max(0, int(x0) - margin_px), int(x1) + margin_px)


def box_iou(a: Sequence[float], b: Sequence[float]) -> float:
    """Intersection over union of two boxes x0, y0, x1, y1."""
    width = min(a[2], b[2]) - max(a[0], b[0])
    height = min(a[3], b[3]) - max(a[1], b[1])
    both = max(0.0, width) * max(0.0, height)
    union = (a[2] - a[0]) * (a[3] - a[1]) + (b[2] - b[0]) * (b[3] - b[1]) - both
    return both / union if union > 0.0 else 0.0
