"""Which back-ends there are, by the name in the configuration."""

from collections.abc import Callable
from typing import Final

from surefetch.perception.classical import classical_backend
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.ports import Backend

BACKENDS: Final[dict[str, Callable[[LatestGeometry], Backend]]] = {"classical": classical_backend}
