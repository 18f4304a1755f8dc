"""What the robot could do after every history of looks: the executor's judgement, without a robot.

The executor plans from the arm's joints, its hand, what it has put down, and the estimate. All of
these are known of a recorded state, so that its own code can be asked afterwards:

- The joints are those with which the state was recorded. The recording arm comes along straight
  joint moves; a live one may come to the same view in another of its branches.
- After a removal the hand is as it lets go of the lid, and the lid lies where the first removal
  that was found would put it. After other looks it would lie millimetres elsewhere.
- Random numbers of the path search are the recording's own. They matter only to motions that have
  no straight way.

Many histories lead to the same estimate, but for the numbers of its tracks, because a body that is
seen again is where it was seen last. Each estimate is judged once in each state, with its tracks
numbered in an order of its own; that cuts 30 histories of a covered scene to eight or nine.
"""

import hashlib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count
from typing import Final

import msgspec
import numpy as np

from surefetch.common import codec
from surefetch.common.cell import Cell, InformRow
from surefetch.common.messages import (
    AskFeasible,
    Estimate,
    Feasibility,
    GraspVerdict,
    InformVerdict,
    Message,
)
from surefetch.common.streams import stream
from surefetch.common.topics import EXECUTE
from surefetch.evaluation.recordings.histories import Known, histories
from surefetch.evaluation.recordings.motion_times import lid_s, pick_s, steps_s
from surefetch.evaluation.recordings.recording import (
    FeasibleAfter,
    Looks,
    Shot,
    after,
)
from surefetch.executor.feasibility import judge
from surefetch.executor.grasping.antipodal import AntipodalProposer
from surefetch.executor.motion.infeasible import Infeasible
from surefetch.executor.motion.planner import Tool
from surefetch.executor.skills.lid_removal import LidRemoval, knob_of
from surefetch.executor.skills.pick import opening_m
from surefetch.executor.skills.plans import Plans
from surefetch.executor.skills.put_down import RELEASE_M
from surefetch.executor.skills.situation import Memory, Situation, Workcell, surroundings

WHO: Final = "recording"
A_TRACK: Final = re.compile(r"\btrack (\d+)")

Grasps = tuple[tuple[GraspVerdict, float | None], ...]
"""Verdicts, each with the time of the motions that were planned for it."""
Informing = tuple[InformVerdict, float | None]


@dataclass(frozen=True, eq=False)
class Hand:
    """How far it is open, and what it has put down."""

    width_m: float = 0.0
    memory: Memory = field(default_factory=Memory)


def prospects(
    shots: Sequence[Shot], covered: bool, cell: Cell, address: tuple[str, int]
) -> tuple[FeasibleAfter, ...]:
    """The executor's verdicts after every history of `histories`, those under the cover first.

    Args:
        shots: every state of a scene.
        covered: whether it begins with a cover on.
        cell: the robot's.
        address: family and seed.
    """
    seen = {shot.state: shot for shot in shots}
    known: dict[Looks, Known] = {(): Known()}
    judging, found = Judging(cell, address), []
    for looks in sorted(histories(covered, cell), key=_opened):
        shot = seen[looks[-1]]
        known[looks] = known[looks[:-1]].after(shot.state.view, shot.observations)
        hand = judging.emptied if _opened(looks) else Hand()
        found.append(judging.after(looks, shot, known[looks], hand))
    return tuple(found)


def _opened(looks: Looks) -> bool:
    return looks[-1].cover == "open"


class Judging:
    """One scene, judged by the executor's planning, whose answers are kept."""

    def __init__(self, cell: Cell, address: tuple[str, int]) -> None:
        self.emptied = Hand()
        """The hand after the first removal that was found."""
        self._cell = cell
        self._rows = cell.rows(views_while_covered=True)
        self._workcell = Workcell.of(cell, AntipodalProposer())
        self._plans = Plans(self._workcell)
        self._dice = (stream(*address, "motion", WHO, n) for n in count())
        self._grasps: dict[bytes, Grasps] = {}
        self._informs: dict[tuple[bytes, str], Informing] = {}

    def after(self, looks: Looks, shot: Shot, known: Known, hand: Hand) -> FeasibleAfter:
        """The verdicts after looks of which this shot is the last."""
        estimate, own = _renumbered(known.estimate)
        now = Situation(np.asarray(shot.q_rad), hand.width_m, estimate, hand.memory)
        key = _digest(estimate) + repr(shot.state).encode()
        grasps = [_told_of(verdict, own, s) for verdict, s in self._of_tracks(key, now)]
        informs = [self._of_inform(key, now, row) for row in self._open_to(looks, known)]
        return FeasibleAfter(
            looks=looks,
            feasibility=Feasibility(
                grasps=tuple(sorted((v for v, _ in grasps), key=lambda v: v.track)),
                informs=tuple(verdict for verdict, _ in informs),
                duration_s=0.0,
            ),
            informs_s={verdict.name: s for verdict, s in informs if s is not None},
            grasps_s={verdict.track: s for verdict, s in grasps if s is not None},
        )

    def _open_to(self, looks: Looks, known: Known) -> Iterator[InformRow]:
        """Information actions that show something new, as far as perception knows the cover."""
        for row in self._rows:
            if row.requires == known.cover and after(looks[-1], row) not in looks:
                yield row

    def _of_tracks(self, key: bytes, now: Situation) -> Grasps:
        if key not in self._grasps:
            told = self._judge(now, grasps=tuple(track.id for track in now.estimate.tracks))
            self._grasps[key] = tuple((v, self._grasp_s(now, v.track)) for v in told.grasps)
        return self._grasps[key]

    def _of_inform(self, key: bytes, now: Situation, row: InformRow) -> Informing:
        if (key, row.name) not in self._informs:
            (verdict,) = self._judge(now, informs=(row.name,)).informs
            self._informs[key, row.name] = verdict, self._inform_s(now, row)
        return self._informs[key, row.name]

    def _judge(
        self, now: Situation, grasps: tuple[int, ...] = (), informs: tuple[str, ...] = ()
    ) -> Feasibility:
        ask = AskFeasible(
            episode=WHO, step=0, estimate=now.estimate, grasps=grasps, informs=informs
        )
        return judge(self._plans, self._cell, now, ask, next(self._dice))

    def _grasp_s(self, now: Situation, track: int) -> float | None:
        """By the plan that the verdict was given for."""
        pick, _ = self._plans.target(now, track, next(self._dice))
        return None if pick is None else pick_s(pick, now.width_m)

    def _inform_s(self, now: Situation, row: InformRow) -> float | None:
        """By the plan that the verdict was given for."""
        if row.kind == "view":
            step = self._plans.view(now, row.view, next(self._dice))
            return None if isinstance(step, Infeasible) else steps_s([step])
        plan = self._plans.lid(now, next(self._dice))
        if isinstance(plan, Infeasible):
            return None
        hand = _hand_after(self._workcell, plan)
        if not self.emptied.memory.placed:
            self.emptied = hand
        return lid_s(plan, now.width_m) + self._look_under_s(now, plan, hand, row)

    def _look_under_s(self, now: Situation, plan: LidRemoval, hand: Hand, row: InformRow) -> float:
        """From where the lid was let go to the view; no time where there is no way."""
        at = plan.put_down.retreat.end_rad
        then = Situation(at, hand.width_m, now.estimate, hand.memory)
        around = surroundings(self._workcell, then, lid=False)
        view, tool = self._cell.view(row.view), Tool(hand.width_m)
        try:
            move = self._workcell.motion.to_view(at, view, around, tool, next(self._dice))
        except Infeasible:
            return 0.0
        return float(move.times_s[-1])


def _hand_after(workcell: Workcell, plan: LidRemoval) -> Hand:
    """The hand when it has let go of the lid."""
    width_m = opening_m(workcell, plan.pick.way.object_width_m, RELEASE_M)
    return Hand(width_m, Memory().put(plan.put_down.box, knob_of(plan)))


def _renumbered(estimate: Estimate) -> tuple[Estimate, Mapping[int, int]]:
    """The same with everything in an order of its own, and the numbers that its tracks had."""
    nameless = {
        t.id: msgspec.structs.replace(t, id=0, n_observations=0, y0=None, last_step=0)
        for t in estimate.tracks
    }
    in_order = sorted(nameless, key=lambda number: _digest(nameless[number]))
    tracks = tuple(
        msgspec.structs.replace(nameless[own], id=n) for n, own in enumerate(in_order, start=1)
    )
    obstacles = tuple(sorted(estimate.obstacles, key=_digest))
    renumbered = msgspec.structs.replace(estimate, tracks=tracks, obstacles=obstacles)
    return renumbered, dict(enumerate(in_order, start=1))


def _told_of(
    verdict: GraspVerdict, own: Mapping[int, int], s: float | None
) -> tuple[GraspVerdict, float | None]:
    """The verdict with tracks named as they are known."""
    why = A_TRACK.sub(lambda found: f"track {own[int(found[1])]}", verdict.why)
    return msgspec.structs.replace(verdict, track=own[verdict.track], why=why), s


def _digest(message: Message) -> bytes:
    encoded = codec.encode(message, max_bytes=EXECUTE.max_request_bytes)
    return hashlib.blake2b(encoded, digest_size=16).digest()
