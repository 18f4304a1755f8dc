"""A simulated table as plain values, and the scorer's questions to the simulated cell.

Only the simulated cell and the scorer use these; perception, belief and planner never see them.
"""

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from surefetch.common import arrays
from surefetch.common.messages.base import Message, Name, Xyz
from surefetch.common.messages.frame import FrameId

Shape = Literal["cube", "block", "cylinder", "ball", "hexagonal prism"]
MarkingKind = Literal["plain", "stripe", "dot", "cross"]
Face = Literal["front", "right", "top"]
InjectedKind = Literal["grasp", "view", "cover"]
Rgb = tuple[float, float, float]
"""Linear 0 … 1."""


class Marking(Message, frozen=True):
    """A patch on one face, in the body's own axes: front is -x (towards the robot), right is -y."""

    kind: MarkingKind
    face: Face
    rgb: Rgb
    coverage: float
    """Share of the face, 0.3 … 0.6."""


class Body(Message, frozen=True):
    """A loose object that stands upright. Position is the centre of its bottom."""

    name: Name
    shape: Shape
    size_m: Xyz
    """Full sizes along its own x, y, z. Round bodies: x = y = diameter; a ball's z is its diameter
    less the 2 mm that are cut off below. A hexagonal prism has flat sides at -x and +x and corners
    at -y and +y: x is across flats, y across corners (1.1547 x when regular)."""
    rgb: Rgb
    marking: Marking | None
    mass_kg: float
    position_world_m: Xyz
    yaw_rad: float


class Container(Message, frozen=True):
    """Walls and a floor, fixed to the table. Position is the centre of its bottom."""

    kind: Literal["tray", "open box", "bin", "crate"]
    inner_size_m: tuple[float, float]
    wall_height_m: float
    wall_thickness_m: float
    floor_thickness_m: float
    rgb: Rgb
    position_world_m: Xyz
    yaw_rad: float
    covered: bool
    lid_rgb: Rgb


class Screen(Message, frozen=True):
    """A matt grey wall, fixed to the table: an obstacle, never an object."""

    size_m: Xyz
    position_world_m: Xyz
    yaw_rad: float


class Lighting(Message, frozen=True):
    """One directional light with shadows."""

    direction: Xyz
    """From the scene to the light, of any length."""
    ambient: float
    diffuse: float
    specular: float


class CameraSpec(Message, frozen=True):
    """The simulated camera's image size and field of view."""

    width: int = 640
    height: int = 480
    vertical_fov_deg: float = 50.0


class Injection(Message, frozen=True):
    """A failure that is only reported: the word that an attempt failed, in its place.

    See `surefetch.common.injections`.
    """

    kind: InjectedKind
    occurrence: int | None = None
    """Counted from 1 within an episode; None: any attempt, at the rate."""
    rate: float = 1.0
    """Chance of each attempt, 0 … 1."""

    def __str__(self) -> str:
        return f"{self.kind}@{self.rate if self.occurrence is None else self.occurrence}"


class Scene(Message, frozen=True):
    """Everything physical on one table, the seed of its hidden noise, and what is to go wrong."""

    family: Name
    seed: int
    generator_version: int
    bodies: tuple[Body, ...]
    container: Container | None
    screens: tuple[Screen, ...]
    lighting: Lighting
    table_rgb: Rgb
    camera: CameraSpec = CameraSpec()
    injected: tuple[Injection, ...] = ()
    """Attempts that the simulated executor reports as failed instead of making them."""


class SceneLoaded(Message, frozen=True):
    """The simulated cell holds this scene, settled, the arm at home."""

    bodies: int
    largest_shift_m: float


class AskTruth(Message, frozen=True):
    """The scorer's question. `frame`: also the segmentation of that frame."""

    frame: FrameId | None = None


class BodyTruth(Message, frozen=True):
    """Where a body is now. Position is the centre of its bottom in its own axes."""

    name: Name
    position_world_m: Xyz
    quaternion_xyzw: tuple[float, float, float, float]


class Truth(Message, frozen=True, eq=False):
    """The simulated cell's own state, for scoring alone."""

    bodies: tuple[BodyTruth, ...]
    lid_position_world_m: Xyz | None
    touched: tuple[Name, ...]
    """Bodies that both fingers have closed on since the scene was loaded, in order."""
    held: str | None
    segmentation: NDArray[np.int16] | None
    """(h, w): index into `bodies`; -1 nothing, -2 container, -3 lid, -4 screen, -5 table, -6 arm"""

    def __post_init__(self) -> None:
        if self.segmentation is not None:
            arrays.check("segmentation", self.segmentation, np.int16, (None, None))
