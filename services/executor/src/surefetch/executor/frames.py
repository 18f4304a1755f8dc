"""The latest frames, for whoever asks for their bytes; safe to ask from another thread."""

import threading
from collections import OrderedDict

from surefetch.common.errors import Refused
from surefetch.common.messages import Frame, FrameId

KEPT_BYTES = 256 * 1024 * 1024


class FrameRing:
    """Keeps frames until they are too many bytes; the oldest go first, the newest never."""

    def __init__(self, boot: str, max_bytes: int = KEPT_BYTES) -> None:
        self._boot = boot
        self._max_bytes = max_bytes
        self._frames: OrderedDict[int, Frame] = OrderedDict()
        self._lock = threading.Lock()

    def keep(self, frame: Frame) -> None:
        """Add the newest frame."""
        with self._lock:
            self._frames[frame.info.frame.counter] = frame
            while len(self._frames) > 1 and self._bytes() > self._max_bytes:
                self._frames.popitem(last=False)

    def get(self, frame: FrameId) -> Frame:
        """The frame of this id. Raises Refused: WRONG_BOOT, or GONE with what there is."""
        if frame.boot != self._boot:
            raise Refused("WRONG_BOOT", f"frame {frame.counter} is of another executor process")
        with self._lock:
            if frame.counter not in self._frames:
                kept = f"{min(self._frames)} to {max(self._frames)}" if self._frames else "none"
                raise Refused("GONE", f"frame {frame.counter} is not kept; kept are {kept}")
            return self._frames[frame.counter]

    def _bytes(self) -> int:
        return sum(frame.rgb.nbytes + frame.depth_m.nbytes for frame in self._frames.values())
