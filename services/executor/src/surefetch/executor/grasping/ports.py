"""The port of grasp proposers: points around an object in, ranked grasp poses out."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from surefetch.common.geometry import Array, inverse
from surefetch.common.messages import Refusal
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.robot import ur10e
from surefetch.executor.robot.hand import Hand


@dataclass(frozen=True, eq=False)
class GraspPose:
    """Where the hand closes, and how wide it is before and after."""

    T_world_tcp: Array
    """(4, 4) when closed on the object: midway between the fingertips' ends, z the direction of
    approach, y the closing direction"""
    open_width_m: float
    """Opening while approaching"""
    object_width_m: float
    """Expected between the pads when closed"""
    score: float
    """In (0, 1], larger is better; compares only within one answer"""

    @property
    def T_world_flange(self) -> Array:
        """(4, 4). It stays while the hand closes: the tips come forward as it does."""
        pose: Array = self.T_world_tcp @ inverse(ur10e.tcp(self.object_width_m))
        return pose

    @property
    def T_world_tcp_open(self) -> Array:
        """(4, 4) of the tcp at the end of the approach, the hand still open."""
        pose: Array = self.T_world_flange @ ur10e.tcp(self.open_width_m)
        return pose


class NoGrasp(Infeasible):
    """Nothing to propose. `tried` counts the grasps thought of by what ruled each out."""

    def __init__(self, refusal: Refusal, why: str, tried: dict[Refusal, int]) -> None:
        super().__init__(refusal, why)
        self.tried = tried


class GraspProposer(Protocol):
    """Finds grasps from geometry alone; it knows no arm."""

    def propose(
        self, points_world_m: Array, mask: NDArray[np.bool_], hand: Hand
    ) -> tuple[GraspPose, ...]:
        """Grasps of the masked points that keep clear of the others, the best first, at least one.

        Args:
            points_world_m: (n, 3) surfaces around the object, without the table, which is z = 0.
            mask: (n,) the points of the object to grasp.
            hand: The gripper.

        Raises:
            NoGrasp: estimate (too little of the object is known), aperture (too wide at every
                angle) or access (no room for the hand).
        """
        ...
