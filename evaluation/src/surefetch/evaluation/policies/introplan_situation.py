"""A situation as IntroPlan takes it: numbers that describe it, and the options that it offers.

In the place of a text about the scene stand features of belief, cover and what was looked at.

Source: EVALUATION, IntroPlan; Liang et al., Introspective planning: aligning robots' uncertainty
with inherent task ambiguity (2024).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.common.cell import Cell, InformRow
from surefetch.common.hypotheses import (
    ABS,
    ASKED,
    OBSERVATIONS,
    RELATIONS,
    UNOBS,
    Relation,
    tracked,
)
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.evaluation.policies.matching import suiting
from surefetch.evaluation.policies.observation import Observation

GRASP_FIRST: Final = 0
GRASP_SECOND: Final = 1
LOOK: Final = 2
OPEN: Final = 3
NOT_LISTED: Final = 4
OPTIONS: Final = ("grasp the first", "grasp the second", "look", "open", "not listed")
N_CANDIDATES: Final = 3

Vector = NDArray[np.float64]
Mask = NDArray[np.bool_]
"""(options,)"""


@dataclass(frozen=True)
class Candidate:
    """A track in its likelier relation of those that the instruction allows."""

    track: int
    relation: Relation
    p: float
    share: float
    """Of the track's mass."""
    y0: str | None
    open: bool
    """Whether it may be grasped now."""


def candidates(now: Observation) -> list[Candidate]:
    """All tracks, the most probable first; the older first of equals."""
    grasps = {(grip.track, grip.relation) for grip in now.grasps}
    belief, y0 = now.believed.belief, {track.id: track.y0 for track in now.believed.tracks}
    suits = suiting(now.target.relation)
    found = []
    for track in sorted(y0):
        relation = max(suits, key=lambda r: belief[tracked(track, r)])
        p = belief[tracked(track, relation)]
        total = sum(belief[tracked(track, r)] for r in RELATIONS)
        share = p / total if total > 0.0 else 0.0
        is_open = (track, relation) in grasps
        found.append(Candidate(track, relation, p, share, y0[track], is_open))
    return sorted(found, key=lambda one: -one.p)


def feature_names(cell: Cell) -> tuple[str, ...]:
    """What each feature is."""
    per_candidate = (
        "present", "mass", "share of relation", "open", *(f"y0 {y}" for y in OBSERVATIONS)
    )  # fmt: skip
    return (
        *(f"{name} of {n + 1}" for n in range(N_CANDIDATES) for name in per_candidate),
        "unobs", "abs", "margin", "tracks", "covered",
        *(f"at {view.name}" for view in cell.views),
        *(f"used {row.name}" for row in _rows(cell)),
        *(f"asked {asked}" for asked in ASKED),
    )  # fmt: skip


def features(now: Observation, view: str) -> Vector:
    """(features,), as `feature_names` names them; `view` is that of the latest look."""
    best = candidates(now)[:N_CANDIDATES]
    belief = now.believed.belief
    masses = [one.p for one in best] + [0.0, 0.0]
    return np.array(
        [
            *(value for n in range(N_CANDIDATES) for value in _described(best[n : n + 1])),
            belief[UNOBS], belief[ABS], masses[0] - masses[1], len(now.believed.tracks),
            now.cover == "covered",
            *(view == one.name for one in now.cell.views),
            *(row.name in now.used for row in _rows(now.cell)),
            *(now.target.relation == asked for asked in ASKED),
        ],
        dtype=np.float64,
    )  # fmt: skip


def _described(one: list[Candidate]) -> Iterator[float]:
    """Of at most one candidate."""
    if not one:
        yield from (0.0,) * (4 + len(OBSERVATIONS))
        return
    yield from (1.0, one[0].p, one[0].share, float(one[0].open))
    yield from (float(one[0].y0 == y) for y in OBSERVATIONS)


def choices(now: Observation) -> tuple[Choice | None, ...]:
    """What each option stands for; None: it is not open.

    Of the views it is the cheapest. On development scenes that is also the one that is right most
    often, whatever is covered and asked for.
    """
    best = [*candidates(now)[:2], None, None]
    grasps = [
        Grasp(track=one.track, relation=one.relation) if one is not None and one.open else None
        for one in best[:2]
    ]
    return (*grasps, _cheapest(now, "view"), _cheapest(now, "remove_cover"), Defer())


def _cheapest(now: Observation, kind: str) -> Inform | None:
    rows = [row for row in now.informs if row.kind == kind]
    best = min(rows, key=lambda row: row.cost, default=None)
    return None if best is None else Inform(name=best.name)


def _rows(cell: Cell) -> tuple[InformRow, ...]:
    return cell.informs + cell.covered_views
