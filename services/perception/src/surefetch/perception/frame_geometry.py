"""What depth alone says of a frame, worked out once and shared by all that ask about that frame."""

from collections.abc import Sequence
from dataclasses import dataclass

from surefetch.common.errors import BadInput
from surefetch.common.mask import Bits
from surefetch.common.rgbd_folder import RgbdFrame
from surefetch.perception import container as containers
from surefetch.perception import foreground as foregrounds
from surefetch.perception import surface as surfaces
from surefetch.perception.container import Container
from surefetch.perception.foreground import Foreground
from surefetch.perception.lifting import Lifted, lift
from surefetch.perception.surface import Surface


class NoSupport(BadInput):
    """No level surface in view."""

    def __init__(self) -> None:
        super().__init__(
            "no support plane is visible in the depth image: a table or floor that things stand on "
            "must be in view, over at least a twelfth of the image, and seen from above. For a "
            "camera that is not held upright, give T_world_camera in camera.json."
        )


@dataclass(frozen=True, eq=False)
class Geometry:
    """A lifted frame, the container in it, and what stands on the ground."""

    surface: Surface
    container: Container | None
    foreground: Foreground


def geometry_of(frame: RgbdFrame) -> Geometry:
    """Lift a frame and read its container.

    Raises:
        NoSupport: nothing in view that things could stand on.
    """
    surface = surfaces.lift(frame)
    if surface is None:
        raise NoSupport
    container = containers.find(surface)
    return Geometry(surface, container, foregrounds.find(surface, container))


class LatestGeometry:
    """Keeps the geometry of the frame asked about last, by the frame's identity.

    Proposer, segmenter and the steps around them ask about the same frame, and often the same
    masks, one after the other; each is worked out once.
    """

    def __init__(self) -> None:
        self._latest: tuple[RgbdFrame, Geometry] | None = None
        self._lifted: dict[int, tuple[Bits, Lifted]] = {}

    def of(self, frame: RgbdFrame) -> Geometry:
        """As `geometry_of`, worked out once for one frame."""
        if self._latest is None or self._latest[0] is not frame:
            self._lifted = {}
            self._latest = (frame, geometry_of(frame))
        return self._latest[1]

    def lifted(self, frame: RgbdFrame, masks: Sequence[Bits]) -> tuple[Lifted, ...]:
        """As `lifting.lift`, worked out once for one mask of one frame."""
        found = self.of(frame)
        new = [bits for bits in masks if id(bits) not in self._lifted]
        for bits, lifted in zip(new, lift(found.surface, found.container, new), strict=True):
            self._lifted[id(bits)] = (bits, lifted)
        return tuple(self._lifted[id(bits)][1] for bits in masks)
