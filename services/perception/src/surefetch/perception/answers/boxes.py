"""Which boxes could stand where a partly hidden box is seen. Pure.

What an occluder hides may be longer than it looks. Every length is tried that background seen
beside the body does not rule out.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np

from surefetch.perception.answers.see_through import Window
from surefetch.perception.solids import Solid

BLOCK_ASPECT: Final = 1.6
"""A block's longest by its shortest side is at least this; a cube's is 1."""
NEARLY: Final = 1.5
"""A fitted box of this aspect is a block, up to the error of the fit."""
LONGER: Final = (1.25, 1.6, 2.0)
ENDS: Final = (-1, 1)
SLACK_PX: Final = 6.0
MOST: Final = 6


@dataclass(frozen=True)
class CubeOrBlock:
    """Pixels that speak against the likeliest cube and the likeliest block."""

    against_cube_px: float
    against_block_px: float


def cube_or_block(window: Window, box: Solid) -> CubeOrBlock:
    """How well the best cube and the best block of this box's height stand there."""
    return CubeOrBlock(
        min(window.against_px(cube) for cube in _cubes(box)),
        min(window.against_px(block) for block in _blocks(box)),
    )


def possible(window: Window, box: Solid) -> list[Solid]:
    """The box, and longer ones that what is seen allows."""
    allowed = window.against_px(box) + SLACK_PX
    longer = [
        (axis, end, factor)
        for axis, end, factor in product((0, 1), ENDS, LONGER)
        if window.against_px(_grown(box, axis, end, factor * box.size_m[axis])) <= allowed
    ]
    found = [box, *(_grown(box, axis, end, k * box.size_m[axis]) for axis, end, k in longer)]
    both = [
        _grown(_grown(box, 0, end, k * box.size_m[0]), 1, other_end, j * box.size_m[1])
        for axis, end, k in longer
        if axis == 0
        for other_axis, other_end, j in longer
        if other_axis == 1
    ]
    return [*found, *(one for one in both[:MOST] if window.against_px(one) <= allowed)]


def aspect(box: Solid) -> float:
    """Longest by shortest side."""
    sides = (*box.size_m, box.top_m - box.base_m)
    return max(sides) / max(min(sides), 1e-3)


def _cubes(box: Solid) -> Iterator[Solid]:
    """Cubes of the box's height, flush with either end or centred on both axes."""
    side = box.top_m - box.base_m
    for end, other_end in product((-1, 0, 1), repeat=2):
        yield _grown(_grown(box, 0, end, side), 1, other_end, side)


def _blocks(box: Solid) -> Iterator[Solid]:
    """The box itself if it is a block, else the shortest blocks that contain it."""
    if aspect(box) >= NEARLY:
        yield box
        return
    height = box.top_m - box.base_m
    for axis, end in product((0, 1), ENDS):
        yield _grown(box, axis, end, BLOCK_ASPECT * min(height, box.size_m[1 - axis]))


def _grown(box: Solid, axis: int, end: int, length_m: float) -> Solid:
    """The box with another length on one axis; `end` is the direction in which it grows."""
    shift = 0.5 * end * (length_m - box.size_m[axis])
    angle = box.yaw_rad + axis * np.pi / 2
    a, b = box.size_m
    return replace(
        box,
        x_m=box.x_m + shift * float(np.cos(angle)),
        y_m=box.y_m + shift * float(np.sin(angle)),
        size_m=(length_m, b) if axis == 0 else (a, length_m),
    )
