"""The faces of a fitted solid that may carry a marking, laid flat. Pure.

A face is a patch of coordinates (a, b): a to the side and b upwards, from -1 to 1 between the
face's edges. Flat faces are whole; on round bodies a face is a sector of 90 degrees and on a
six-sided one of 60; a ball's top is the cap within 45 degrees of its pole.

Bodies of the vocabulary carry a marking in front (towards the robot, -x), on the right (-y) or on
top, and those whose marking decides are turned by at most 15 degrees.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from surefetch.common.geometry import Array
from surefetch.perception.answers.faces import Bools, Surfaces, outline_of
from surefetch.perception.solids import Solid

CARRIERS_RAD: Final = (np.pi, -np.pi / 2)
"""World azimuths of the side faces that may carry a marking: front and right."""
MAX_TURN_RAD: Final = float(np.radians(18.0))
"""The allowed turn and the error of a fit"""
TURNS_RAD: Final = np.radians(np.arange(-18.0, 18.1, 3.0))
ROUND_HALF_RAD: Final = float(np.pi / 4)
HEXAGON_HALF_RAD: Final = float(np.pi / 6)
ROUND_TOP_TURNS: Final = np.radians(np.arange(0.0, 180.0, 7.5))


@dataclass(frozen=True, eq=False)
class Patch:
    """Pixels on one face, flat."""

    name: str
    carrier: bool
    """Bodies of the vocabulary may carry their marking here."""
    on: Bools
    """(n,) of all pixels: those on this face"""
    a: Array
    """(m,) of the pixels on the face"""
    b: Array
    half_m: tuple[float, float]
    """Half lengths along a and b"""
    cosine: Array
    """(m,)"""


def patches(surfaces: Surfaces, marked_azimuth_rad: float | None) -> Iterator[Patch]:
    """Every way in which a face can lie.

    Args:
        surfaces: the pixels on the solid.
        marked_azimuth_rad: where a marking seems to be on a round side; also tried.
    """
    kind = surfaces.solid.kind
    if kind == "ball":
        yield from _caps(surfaces)
    else:
        yield from _tops(surfaces)
    if kind == "box":
        yield from _box_sides(surfaces)
    else:
        yield from _sectors(surfaces, marked_azimuth_rad)


def carriers_known(solid: Solid) -> bool:
    """Whether a solid's turn tells which of its faces may carry a marking.

    A box or a six-sided prism that is turned farther than markings allow may be turned by any
    number of its sides. Round ones look the same at every turn.
    """
    sides = {"box": 4, "hexagonal prism": 6}.get(solid.kind)
    if sides is None:
        return True
    turn = float(wrapped(np.array(solid.yaw_rad * sides))) / sides
    return abs(turn) <= MAX_TURN_RAD


def wrapped(angle_rad: Array) -> Array:
    """Angles in [-pi, pi)."""
    out: Array = (angle_rad + np.pi) % (2 * np.pi) - np.pi
    return out


def _tops(surfaces: Surfaces) -> Iterator[Patch]:
    solid = surfaces.solid
    on = surfaces.on_top
    x, y = surfaces.own_m[on, 0], surfaces.own_m[on, 1]
    width, depth = solid.size_m
    if solid.kind == "box":
        turns, halves = np.array([0.0, np.pi / 2]), [(depth / 2, width / 2), (width / 2, depth / 2)]
    elif solid.kind == "hexagonal prism":
        turns, halves = np.arange(3) * (np.pi / 3), [(width / np.sqrt(3.0), width / 2)] * 3
    else:
        turns, halves = ROUND_TOP_TURNS, [(width / 2, width / 2)] * len(ROUND_TOP_TURNS)
    for turn, (half_a, half_b) in zip(turns, halves, strict=True):
        up, across = x * np.cos(turn) + y * np.sin(turn), x * np.sin(turn) - y * np.cos(turn)
        yield Patch(
            "top", True, on, across / half_a, up / half_b, (half_a, half_b), surfaces.cosine[on]
        )


def _caps(surfaces: Surfaces) -> Iterator[Patch]:
    radius = surfaces.solid.size_m[0] / 2
    z = np.clip(surfaces.own_m[:, 2] / radius, -1.0, 1.0)
    from_pole = np.arccos(z)
    on = from_pole < ROUND_HALF_RAD
    azimuth, far = surfaces.azimuth_rad[on], from_pole[on] / ROUND_HALF_RAD
    half = ROUND_HALF_RAD * radius
    for turn in ROUND_TOP_TURNS:
        a, b = far * np.sin(azimuth - turn), far * np.cos(azimuth - turn)
        yield Patch("top", True, on, a, b, (half, half), surfaces.cosine[on])


def _box_sides(surfaces: Surfaces) -> Iterator[Patch]:
    solid = surfaces.solid
    azimuths, _ = outline_of(solid)
    half_z = 0.5 * (solid.top_m - solid.base_m)
    for index, azimuth in enumerate(azimuths):
        on = surfaces.side == index
        half_a = solid.size_m[1 - index % 2] / 2
        along = surfaces.own_m[on, 1] * np.cos(azimuth) - surfaces.own_m[on, 0] * np.sin(azimuth)
        name = _carrier(azimuth + solid.yaw_rad)
        yield Patch(
            name or f"side {index}",
            name is not None,
            on,
            along / half_a,
            surfaces.own_m[on, 2] / half_z,
            (half_a, half_z),
            surfaces.cosine[on],
        )


def _carrier(azimuth_rad: float) -> str | None:
    for name, carrier in zip(("front", "right"), CARRIERS_RAD, strict=True):
        if abs(wrapped(np.array(azimuth_rad - carrier))) < np.pi / 4:
            return name
    return None


def _sectors(surfaces: Surfaces, marked_azimuth_rad: float | None) -> Iterator[Patch]:
    solid = surfaces.solid
    radius = solid.size_m[0] / 2
    half = HEXAGON_HALF_RAD if solid.kind == "hexagonal prism" else ROUND_HALF_RAD
    if solid.kind == "ball":
        up = np.arcsin(np.clip(surfaces.own_m[:, 2] / radius, -1.0, 1.0)) * radius
        half_up = half * radius
    else:
        up, half_up = surfaces.own_m[:, 2], 0.5 * (solid.top_m - solid.base_m)
    azimuth = surfaces.azimuth_rad
    for name, carrier, center in _centers(surfaces, marked_azimuth_rad):
        across = wrapped(azimuth - center)
        on = (np.abs(across) < half) & (np.abs(up) <= half_up * 1.05) & ~surfaces.on_top
        yield Patch(
            name,
            carrier,
            on,
            across[on] / half,
            up[on] / half_up,
            (half * radius, half_up),
            surfaces.cosine[on],
        )


def _centers(
    surfaces: Surfaces, marked_azimuth_rad: float | None
) -> Iterator[tuple[str, bool, float]]:
    solid = surfaces.solid
    if solid.kind == "hexagonal prism":
        for k in range(12):
            center = solid.yaw_rad + k * (np.pi / 6)
            # in front a flat side, on the right a corner
            flat = k % 2 == 0
            front, right = (abs(wrapped(np.array(center - c))) for c in CARRIERS_RAD)
            if flat and front < np.pi / 6:
                yield "front", True, center
            elif not flat and right < np.pi / 6:
                yield "right", True, center
            else:
                yield f"side {k}", False, center
        return
    for name, carrier in zip(("front", "right"), CARRIERS_RAD, strict=True):
        for turn in TURNS_RAD:
            yield name, True, float(carrier + turn)
    if marked_azimuth_rad is not None:
        for turn in np.radians([-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0]):
            yield "side", False, float(marked_azimuth_rad + turn)
