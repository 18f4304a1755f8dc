"""Pictures of recorded states: compressed, but what the camera showed."""

import numpy as np
import pytest

from surefetch.common.errors import BadInput
from surefetch.evaluation.recordings.pictures import Picture, Pictures
from surefetch.evaluation.recordings.recording import State

RIGHT, CENTER = State(view="right", cover="none"), State(view="center", cover="none")


def test_a_picture_shows_its_state_in_its_colours() -> None:
    ramp = np.linspace(0, 255, 64).astype(np.uint8)
    rgb = np.stack(np.broadcast_arrays(ramp[None], ramp[:, None], np.uint8(40)), axis=-1)
    pictures = Pictures(format=2, family="f", seed=1, pictures=(Picture.of(RIGHT, rgb),))
    off = np.abs(pictures.rgb(RIGHT).astype(int) - rgb.astype(int))
    assert off.mean() < 3.0
    with pytest.raises(BadInput, match="f:1 has no picture from center with cover none"):
        pictures.jpeg(CENTER)


def test_a_damaged_picture_is_told() -> None:
    broken = Picture(state=RIGHT, jpeg=b"no picture")
    pictures = Pictures(format=2, family="f", seed=1, pictures=(broken,))
    with pytest.raises(BadInput, match="damaged"):
        pictures.rgb(RIGHT)
