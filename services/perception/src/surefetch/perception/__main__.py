"""Wiring of the perception service: `surefetch serve perception`."""

import cv2

from surefetch.common.bus import Bus
from surefetch.common.runner import serve
from surefetch.common.settings import read_settings
from surefetch.common.topics import PERCEPTION
from surefetch.perception.backends import BACKENDS
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.service import PerceptionService


def main(argv: list[str]) -> int:
    """Serve until told to stop. Raises BadInput for settings that cannot be used."""
    settings = read_settings(argv, PERCEPTION)
    cv2.setNumThreads(1)

    def make_service(bus: Bus) -> PerceptionService:
        geometry = LatestGeometry()
        return PerceptionService(bus, BACKENDS[settings.perception](geometry), geometry)

    return serve(make_service, settings)
