"""What the camera showed in every state of a recorded scene, for figures and galleries.

Kept apart from the recording, because replaying needs no picture. Colours are off by what JPEG
takes; nothing is perceived from these.
"""

from typing import Final

import cv2
import numpy as np
from numpy.typing import NDArray

from surefetch.common.errors import BadInput
from surefetch.common.messages import Message, Name
from surefetch.evaluation.recordings.recording import State

QUALITY: Final = 90


class Picture(Message, frozen=True):
    """One."""

    state: State
    jpeg: bytes

    @classmethod
    def of(cls, state: State, rgb: NDArray[np.uint8]) -> "Picture":
        """A colour image (h, w, 3), compressed."""
        _, encoded = cv2.imencode(
            ".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
        )
        return cls(state=state, jpeg=encoded.tobytes())


class Pictures(Message, frozen=True):
    """All of one scene."""

    format: int
    family: Name
    seed: int
    pictures: tuple[Picture, ...]

    def jpeg(self, state: State) -> bytes:
        """The file that shows a state. Raises BadInput when there is none."""
        for picture in self.pictures:
            if picture.state == state:
                return picture.jpeg
        raise BadInput(
            f"{self.family}:{self.seed} has no picture from {state.view} with cover {state.cover}."
        )

    def rgb(self, state: State) -> NDArray[np.uint8]:
        """The image (h, w, 3) of a state. Raises BadInput when there is none."""
        encoded = np.frombuffer(self.jpeg(state), np.uint8)
        bgr = cv2.imdecode(encoded, cv2.IMREAD_COLOR)
        if bgr is None:
            raise BadInput(f"a picture of {self.family}:{self.seed} is damaged. Record it again.")
        return np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)
