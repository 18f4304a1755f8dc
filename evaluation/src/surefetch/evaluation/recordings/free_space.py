"""Which part of the working area was seen to be free, seen to be filled, or not seen. Pure.

A grid of voxels over the table. Each is told by its centre alone: in front of the measured depth
it is free, at it filled, behind it or outside the image not seen.
"""

import zlib
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import inverse
from surefetch.common.messages import Frame, Message

Grid = NDArray[np.int8]
"""(nx, ny, nz) of UNSEEN, FREE or FILLED"""

UNSEEN: Final = 0
FREE: Final = 1
FILLED: Final = 2

VOXEL_M: Final = 0.01
ORIGIN_WORLD_M: Final = (0.65, -0.40, 0.0)
"""The corner of the grid with the lowest coordinates."""
SHAPE: Final = (60, 80, 20)
_BITS: Final = 2


class FreeSpace(Message, frozen=True):
    """One grid, two bits a voxel, deflated."""

    cells: bytes

    @classmethod
    def of(cls, grid: Grid) -> "FreeSpace":
        """The grid, packed."""
        return cls(cells=zlib.compress(_packed(grid), level=6))

    def grid(self) -> Grid:
        """The voxels, (nx, ny, nz)."""
        packed = np.frombuffer(zlib.decompress(self.cells), np.uint8)
        shifts = np.arange(0, 8, _BITS, dtype=np.uint8)
        values = (packed[:, None] >> shifts) & ((1 << _BITS) - 1)
        return values.reshape(SHAPE).astype(np.int8)


def seen_in(frame: Frame) -> Grid:
    """What one frame tells of every voxel."""
    z_m, u, v = _projected(frame)
    height, width = frame.depth_m.shape
    inside = (z_m > 0.0) & (u >= 0) & (u < width) & (v >= 0) & (v < height)
    depth_m = np.zeros(len(z_m))
    depth_m[inside] = frame.depth_m[v[inside], u[inside]]
    measured = depth_m > 0.0
    grid = np.full(len(z_m), UNSEEN, np.int8)
    grid[measured & (z_m < depth_m - VOXEL_M)] = FREE
    grid[measured & (np.abs(z_m - depth_m) <= VOXEL_M)] = FILLED
    return grid.reshape(SHAPE)


def fused(grids: Sequence[Grid]) -> Grid:
    """What several looks tell together: the latest that saw a voxel counts."""
    together = np.full(SHAPE, UNSEEN, np.int8)
    for grid in grids:
        together = np.where(grid == UNSEEN, together, grid)
    return together


def centers_world_m() -> NDArray[np.float64]:
    """(nx·ny·nz, 3), in the order of a raveled grid."""
    axes = [
        low + VOXEL_M * (np.arange(n) + 0.5) for low, n in zip(ORIGIN_WORLD_M, SHAPE, strict=True)
    ]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _projected(
    frame: Frame,
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Depth along the optical axis, column and row of every voxel's centre."""
    T_camera_world = inverse(frame.info.T_world_camera)
    at_camera_m = centers_world_m() @ T_camera_world[:3, :3].T + T_camera_world[:3, 3]
    z_m = at_camera_m[:, 2]
    pixels = at_camera_m @ frame.info.K.T / np.where(np.abs(z_m) < 1e-9, 1e-9, z_m)[:, None]
    return z_m, np.rint(pixels[:, 0]).astype(np.int64), np.rint(pixels[:, 1]).astype(np.int64)


def _packed(grid: Grid) -> bytes:
    per_byte = 8 // _BITS
    shifts = np.arange(0, 8, _BITS, dtype=np.uint8)
    values = grid.astype(np.uint8).reshape(-1, per_byte)
    packed: NDArray[np.uint8] = np.bitwise_or.reduce(values << shifts, axis=1)
    return packed.tobytes()
