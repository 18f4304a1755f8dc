"""A scene recorded once: what perception said in every reachable state, and the scorer's own file.

A state is a view and a cover state. The recording holds what a policy may know; the truth lies in
a file of its own, which only fitting, calibrating and scoring read.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import Cell, InformRow
from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import Relation
from surefetch.common.messages import Feasibility, Message, Name, Observations, Target, Text
from surefetch.evaluation.recordings.free_space import FreeSpace

FORMAT: Final = 2
FIRST_VIEW: Final = "center"
FIRST_Q: Final = "center"

Cover = Literal["none", "closed", "open"]
Path = tuple[str, ...]
"""Names of information actions, in the order in which they are taken."""


class State(Message, frozen=True):
    """Where the camera is and what became of the cover."""

    view: Name
    cover: Cover


class Shot(Message, frozen=True, eq=False):
    """One state, captured and perceived."""

    state: State
    observations: Observations
    K: NDArray[np.float64]
    """(3, 3)"""
    T_world_camera: NDArray[np.float64]
    """(4, 4), as the joints measure it"""
    q_rad: tuple[float, ...]
    """The six joints, measured."""
    free_space: FreeSpace


Looks = tuple[State, ...]
"""What was seen in an episode so far, in order, nothing twice."""


class FeasibleAfter(Message, frozen=True):
    """What the robot could do after some looks, as the executor says.

    Asked for all tracks of the estimate that these looks lead to, and for all information actions
    that they leave open.
    """

    looks: Looks
    feasibility: Feasibility
    informs_s: dict[Name, float]
    """Modelled time of the motions of each information action that is feasible."""
    grasps_s: dict[int, float]
    """The same of grasping and lifting each track that can be."""


class MadeWith(Message, frozen=True):
    """What produced a recording. Recordings made with different things are not mixed."""

    surefetch: Name
    """Version of the package."""
    generator_version: int
    generator: Name
    """Digest of the generator's sources: scenes of one digest and seed are the same."""
    cell: Name
    cell_file: Name
    """Digest of the cell file."""
    backend: Name
    """Perception."""
    perception: Name
    """Digest of perception's sources."""
    planning: Name
    """Digest of the sources by which feasibility is judged."""


class Repeated(Message, frozen=True):
    """What came of looking at a scene a second time, from the beginning."""

    candidates: int
    differing: int
    """Those that were put in another category."""


class Recording(Message, frozen=True, eq=False):
    """Everything a policy may learn of one scene."""

    format: int
    family: Name
    seed: int
    made_with: MadeWith
    sentence: Text
    target: Target
    covered: bool
    """Whether the scene begins with a cover on the container."""
    shots: tuple[Shot, ...]
    feasible: tuple[FeasibleAfter, ...]
    """For every history of looks that can arise; see `histories`."""
    repeated: Repeated | None
    """None: it was looked at once."""
    durations_s: dict[str, float]
    """Processor time of recording, by what was done; `perception` is of all shots together."""

    @property
    def cell(self) -> str:
        """Name of the cell."""
        return self.made_with.cell

    @property
    def backend(self) -> str:
        """Name of the perception that answered."""
        return self.made_with.backend

    def shot(self, state: State) -> Observations:
        """What was seen in a state. Raises BadInput when it was not recorded."""
        for shot in self.shots:
            if shot.state == state:
                return shot.observations
        raise BadInput(
            f"{self.family}:{self.seed} was recorded without the view {state.view} with cover "
            f"{state.cover}. Record it again."
        )

    def feasible_after(self, looks: Iterable[State]) -> FeasibleAfter:
        """What the robot could do after some looks; a state that was seen again counts once.

        For a belief without memory, ask with the latest look alone.

        Raises:
            BadInput: no sequence of information actions leads to these looks.
        """
        wanted = tuple(dict.fromkeys(looks))
        for known in self.feasible:
            if known.looks == wanted:
                return known
        told = ", ".join(f"{state.view} ({state.cover})" for state in wanted)
        raise BadInput(
            f"{self.family}:{self.seed} was recorded without what is feasible after {told}."
        )


class ShotTruth(Message, frozen=True):
    """The body under each detection of one state, by the majority of its mask; None: no body."""

    state: State
    bodies: dict[str, str | None]


class BodyMatch(Message, frozen=True):
    """Whether a body has what the target asks for; None: the target does not name it."""

    color: bool | None
    shape: bool | None
    marking: bool | None
    relation: Relation | None
    """Where it stands, asked or not; None on the container's boundary."""


class RecordingTruth(Message, frozen=True):
    """What only the scorer knows of a recorded scene."""

    format: int
    family: Name
    seed: int
    target: str | None
    relation: Relation | None
    graspable: tuple[str, ...]
    """Bodies within the gripper's opening."""
    matches: dict[str, BodyMatch]
    """By name of the body."""
    shots: tuple[ShotTruth, ...]

    def bodies(self, state: State) -> dict[str, str | None]:
        """The body under each detection of a state."""
        return next(shot.bodies for shot in self.shots if shot.state == state)


def first_state(covered: bool) -> State:
    """Where every episode begins."""
    return State(view=FIRST_VIEW, cover="closed" if covered else "none")


def after(state: State, row: InformRow) -> State:
    """The state that an information action leads to, when it succeeds."""
    return State(view=row.view, cover="open" if row.kind == "remove_cover" else state.cover)


def admissible(state: State, used: Iterable[str], rows: Iterable[InformRow]) -> Iterator[InformRow]:
    """Information actions that a policy may take, in tie order."""
    physical = "covered" if state.cover == "closed" else "open"
    spent = set(used)
    return (row for row in rows if row.requires == physical and row.name not in spent)


def paths(covered: bool, cell: Cell, *, views_while_covered: bool = False) -> list[Path]:
    """All sequences of information actions, the empty one first, each after its beginnings."""
    rows = cell.rows(views_while_covered=views_while_covered)

    def grow(path: Path, state: State) -> Iterator[Path]:
        yield path
        for row in admissible(state, path, rows):
            yield from grow((*path, row.name), after(state, row))

    return list(grow((), first_state(covered)))


def exhaustive_path(covered: bool, cell: Cell) -> Path:
    """Everything there is to see: the cover removed if there is one, then all views, in tie order.

    Source: `sec:experiments`; the paths along which the quantile is calibrated.
    """
    path: Path = ()
    state = first_state(covered)
    while (row := next(admissible(state, path, cell.informs), None)) is not None:
        path, state = (*path, row.name), after(state, row)
    return path


def state_after(path: Sequence[str], covered: bool, cell: Cell) -> State:
    """Where a sequence of information actions leads."""
    state = first_state(covered)
    for name in path:
        state = after(state, cell.inform(name))
    return state


def condition_after(path: Sequence[str], cell: Cell) -> str:
    """The viewing condition of the capture at the end of a sequence."""
    return cell.inform(path[-1]).q if path else FIRST_Q


def states(covered: bool, cell: Cell) -> list[State]:
    """The states that can be reached, each once; those under the cover before the others."""
    found = paths(covered, cell, views_while_covered=True)
    reached = dict.fromkeys(state_after(path, covered, cell) for path in found)
    return sorted(reached, key=lambda state: state.cover == "open")
