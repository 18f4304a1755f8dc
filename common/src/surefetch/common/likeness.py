"""How alike two objects look. Pure."""

from collections.abc import Sequence

import numpy as np


def hellinger(p: Sequence[float] | None, q: Sequence[float] | None) -> float:
    """Hellinger distance of two histograms, 0 … 1; 0 when one is missing."""
    if p is None or q is None:
        return 0.0
    overlap = float(np.sqrt(np.multiply(p, q)).sum())
    return float(np.sqrt(max(0.0, 1.0 - overlap)))
