"""A frame's id and a target in, everything seen out. The frame's bytes come from the executor."""

import time
from typing import Any, Final

import numpy as np

from surefetch.common.bus import Bus
from surefetch.common.messages import Empty, Frame, Observations, Observe, Vocabulary
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.common.runner import Handle
from surefetch.common.topics import FRAME, OBSERVE, OBSERVED, PERCEPTION, VOCABULARY
from surefetch.perception.frame_geometry import LatestGeometry
from surefetch.perception.observe import observe
from surefetch.perception.ports import Backend
from surefetch.perception.reply import reply

FRAME_S: Final = 10.0
"""A frame is there already; this is for its way."""


class PerceptionService:
    """Perceives frames of the executor with one back-end."""

    name = PERCEPTION

    def __init__(self, bus: Bus, backend: Backend, geometry: LatestGeometry) -> None:
        self._bus = bus
        self._backend = backend
        self._geometry = geometry
        self._doing = "idle"

    @property
    def backend(self) -> str:
        """The back-end's identity."""
        return self._backend.name

    @property
    def doing(self) -> str:
        """Which frame it looks at."""
        return self._doing

    @property
    def handles(self) -> tuple[Handle[Any, Any], ...]:
        """The two topics; the vocabulary is told also while a frame is looked at."""
        return (
            Handle(OBSERVE, self.observe),
            Handle(VOCABULARY, self.vocabulary, concurrent=True),
        )

    def vocabulary(self, _: Empty) -> Vocabulary:
        """What the back-end understands."""
        return self._backend.vocabulary

    def observe(self, request: Observe) -> Observations:
        """Fetch the frame, perceive it, publish and return what was seen.

        Raises:
            NoSupport: the frame shows nothing that things could stand on.
            InfrastructureError: the executor did not give the frame.
        """
        self._doing = f"frame {request.frame.counter} of {request.episode}"
        try:
            frame = self._bus.ask(FRAME, request.frame, timeout_s=FRAME_S)
            started = time.perf_counter()
            perceived = observe(rgbd_of(frame), request.target, self._backend, self._geometry)
            took_s = time.perf_counter() - started
            seen = reply(perceived, request.frame, self.backend, duration_s=took_s)
        finally:
            self._doing = "idle"
        self._bus.publish(OBSERVED, seen)
        return seen


def rgbd_of(frame: Frame) -> RgbdFrame:
    """The pixels and calibration of a frame, and nothing else of it."""
    return RgbdFrame(
        rgb=np.asarray(frame.rgb),
        depth_m=np.asarray(frame.depth_m),
        K=np.asarray(frame.info.K),
        T_world_camera=np.asarray(frame.info.T_world_camera),
        view=frame.info.view,
    )
