"""Which body lies under a detection, by the simulator's segmentation: for fitting and scoring."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from surefetch.common import mask
from surefetch.common.messages import Mask, Observations


def bodies_under(
    seen: Observations, segmentation: NDArray[np.int16], names: Sequence[str]
) -> dict[str, str | None]:
    """The body that has most of each detection's mask; None where no body has the majority.

    Args:
        seen: Detections of one frame.
        segmentation: (h, w) of the same frame, numbered as in `messages.Truth`.
        names: Of the bodies, in the segmentation's order.
    """
    return {one.id: _under(one.mask, segmentation, names) for one in seen.detections}


def _under(outline: Mask, segmentation: NDArray[np.int16], names: Sequence[str]) -> str | None:
    labels = segmentation[mask.decode(outline)]
    bodies = labels[labels >= 0]
    if not len(bodies):
        return None
    counts = np.bincount(bodies, minlength=len(names))
    return names[int(counts.argmax())] if 2 * counts.max() > len(labels) else None
