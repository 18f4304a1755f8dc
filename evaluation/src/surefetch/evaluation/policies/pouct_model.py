"""A decision problem as pomdp_py (the extra `baselines`) takes it.

A state is the hypothesis and the cover, or that the episode is over. Everything random is drawn
with Python's own generator, as the library does; `pouct_tree` seeds it.

Source: Zheng and Tellex, pomdp_py: A Framework to Build and Solve POMDP Problems (2020).
"""

import random
from bisect import bisect
from collections.abc import Sequence
from itertools import accumulate
from typing import Final

import numpy as np
import pomdp_py

from surefetch.common.cell import InformRow
from surefetch.common.hypotheses import RELATIONS
from surefetch.common.messages import Choice
from surefetch.planner.actions import State
from surefetch.planner.problem import Problem

Symbols = tuple[tuple[int, int], ...]
"""What a look shows: tracks and their symbols, as places in their lists."""
Rows = list[list[list[float]]]
"""[track][class][symbol], or [track][symbol][relation]"""
N_RELATIONS: Final = len(RELATIONS)
NO_TRACK: Final = -1


class Hypothetical(pomdp_py.State):  # type: ignore[misc]
    """A state. There is one object for each, equal only to itself."""

    __hash__ = object.__hash__
    __eq__ = object.__eq__

    def __init__(self, z: int, cover: State) -> None:
        self.z = z
        """Column of the hypothesis: tracks by relation, then unobs, then abs."""
        self.cover: State = cover


class Act(pomdp_py.Action):  # type: ignore[misc]
    """An action. There is one object for each."""

    __hash__ = object.__hash__
    __eq__ = object.__eq__

    def __init__(
        self, choice: Choice | None, row: InformRow | None = None, costs: Sequence[float] = ()
    ) -> None:
        self.choice = choice
        self.row = row
        """Of a look."""
        self.costs = costs
        """Of an end, by hypothesis."""


class Seen(pomdp_py.Observation):  # type: ignore[misc]
    """An observation. There is one object for each."""

    __hash__ = object.__hash__
    __eq__ = object.__eq__

    def __init__(self, cover: State, symbols: Symbols) -> None:
        self.cover: State = cover
        self.symbols = symbols


History = tuple[tuple[Act, Seen], ...]

Drawn = tuple[Hypothetical, Seen, float, int]

OVER: Final = Hypothetical(-1, "open")
END: Final = Seen("open", ())
REST: Final = Act(None)
"""All that is left to do when the episode is over."""


class Start(pomdp_py.GenerativeDistribution):  # type: ignore[misc]
    """The shared belief at the root."""

    def __init__(self, states: Sequence[Hypothetical], masses: Sequence[float]) -> None:
        self._states = states
        self._up_to = list(accumulate(masses))

    def random(self) -> Hypothetical:
        """A state."""
        drawn = random.random() * self._up_to[-1]
        return self._states[bisect(self._up_to, drawn, hi=len(self._states) - 1)]


class Outcomes(pomdp_py.BlackboxModel):  # type: ignore[misc]
    """What comes of actions: (s', o, r) ~ G(s, a); and what a history lets one believe."""

    def __init__(self, problem: Problem, *, all_tracks: bool) -> None:
        self._problem = problem
        self._all_tracks = all_tracks
        belief = problem.belief
        self._masses = [*belief.p_tracked.ravel().tolist(), belief.p_unobs, belief.p_abs]
        self._unobs = len(self._masses) - 2
        self._states: dict[State, list[Hypothetical]] = {
            "open": [Hypothetical(z, "open") for z in range(len(self._masses))],
            "covered": [Hypothetical(z, "covered") for z in range(len(self._masses))],
        }
        self._seen: dict[tuple[State, Symbols], Seen] = {}
        self._up_to: dict[str, Rows] = {}
        self._ratio: dict[str, Rows] = {}
        for row in problem.rows if problem.y0 else ():
            E = np.array([problem.future.likelihood(row, y) for y in problem.y0])
            self._up_to[row.name] = E.cumsum(axis=-1).tolist()
            self._ratio[row.name] = (E[:, :-1] / E[:, -1:]).transpose(0, 2, 1).tolist()

    @property
    def start(self) -> Start:
        """The belief at the root."""
        return Start(self._states[self._problem.state], self._masses)

    def sample(self, state: Hypothetical, action: Act) -> Drawn:
        """State, observation and reward after an action, and that it took one step."""
        if action.row is not None:
            return self._look(state, action.row)
        return OVER, END, 0.0 if action is REST else -action.costs[state.z], 1

    def _look(self, state: Hypothetical, row: InformRow) -> Drawn:
        cover = state.cover
        if row.kind == "remove_cover" and random.random() < self._problem.p_remove:
            cover = "open"
        if state.z == self._unobs and random.random() < self._problem.appears(row, cover):
            return OVER, END, -row.cost - self._problem.found_cost, 1
        shown = cover, self._shown(state.z, row)
        if shown not in self._seen:
            self._seen[shown] = Seen(*shown)
        return self._states[cover][state.z], self._seen[shown], -row.cost, 1

    def _shown(self, z: int, row: InformRow) -> Symbols:
        if not self._up_to:
            return ()
        up_to = self._up_to[row.name]
        target, relation = divmod(z, N_RELATIONS) if z < self._unobs else (NO_TRACK, 0)
        tracks = range(len(up_to)) if self._all_tracks else (int(random.random() * len(up_to)),)
        last = len(up_to[0][0]) - 1
        return tuple(
            (i, bisect(up_to[i][relation if i == target else -1], random.random(), hi=last))
            for i in tracks
        )

    def believed(self, history: History) -> list[float]:
        """Masses of the hypotheses after a history of looks, not normalised."""
        masses = self._masses.copy()
        for action, seen in history:
            assert action.row is not None
            masses[self._unobs] *= 1.0 - self._problem.appears(action.row, seen.cover)
            for i, y in seen.symbols:
                for r, factor in enumerate(self._ratio[action.row.name][i][y]):
                    masses[i * N_RELATIONS + r] *= factor
        return masses
