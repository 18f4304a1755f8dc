"""What came of removing a scene's cover and of grasping its target in the simulator. Scorer's."""

from typing import Final

from surefetch.common.messages import Message, Name, Text

FORMAT: Final = 1
MOST_ATTEMPTS: Final = 3

MOVED_M: Final = 0.003
TURNED_DEG: Final = 2.0
"""Where an attempt that failed moved a body farther than this, the recording no longer holds."""


class Attempt(Message, frozen=True):
    """One try."""

    done: bool
    why: Text
    """In words, where it failed."""
    moved_m: float
    turned_deg: float
    """Of the body that moved most. What was carried away as it should be does not count."""
    duration_s: float
    """Modelled time of its motions."""

    @property
    def disturbed(self) -> bool:
        """Whether the table is not any more as it was recorded."""
        return self.moved_m > MOVED_M or self.turned_deg > TURNED_DEG


class Measured(Message, frozen=True):
    """Attempts in order, up to the first that succeeds: nobody ever asks for a later one.

    Empty where there was nothing to try: no cover, no target, or none that the robot can grasp.
    """

    format: int
    family: Name
    seed: int
    removals: tuple[Attempt, ...]
    grasps: tuple[Attempt, ...]
    """At the target, once it is within reach and was looked at from all sides."""
