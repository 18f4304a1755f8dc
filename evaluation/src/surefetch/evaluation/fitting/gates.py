"""Is the scene generator hard enough, and not too hard? Five trivial policies tell. Pure.

Outcomes are drawn with common random numbers, so that two policies that do the same thing for the
first time share what comes of it.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from surefetch.common.cell import Cell
from surefetch.common.hypotheses import parse_tracked
from surefetch.common.streams import stream
from surefetch.evaluation.recordings.recording import (
    Path,
    Recording,
    RecordingTruth,
    exhaustive_path,
)
from surefetch.evaluation.recordings.walk import Look
from surefetch.evaluation.running.metrics import Scored, Verdict

Walks = Mapping[Path, Sequence[Look]]

P_REMOVE: Final = 0.90
P_VIEW: Final = 0.99
P_GRASP: Final = 0.95
"""Assumed true rates of the three kinds of interaction; design values, nothing measured."""


@dataclass(frozen=True, eq=False)
class Walked:
    """A recorded scene with its looks by sequence."""

    recording: Recording
    truth: RecordingTruth
    walks: Walks


@dataclass(frozen=True)
class Control:
    """A policy without judgement: where it looks, and how sure it must be to grasp."""

    name: str
    path: Callable[[Walked, Cell], Path]
    grasps_above: float
    """Least belief in the best hypothesis; above 1: never grasps."""


def nothing(_: Walked, __: Cell) -> Path:
    """Looks once."""
    return ()


def views_only(walked: Walked, cell: Cell) -> Path:
    """All views, and never opens; under a cover there is no view to take."""
    if walked.recording.covered:
        return ()
    return exhaustive_path(covered=False, cell=cell)


def everything(walked: Walked, cell: Cell) -> Path:
    """Removes the cover if there is one, and takes all views."""
    return exhaustive_path(walked.recording.covered, cell)


LOOK_ONCE: Final = Control("look-once", nothing, 0.0)
VIEWS_ONLY: Final = Control("views-only", views_only, 0.0)
EVERYTHING: Final = Control("everything-threshold", everything, 0.5)
ALWAYS_DEFER: Final = Control("always-defer", nothing, 2.0)
CONTROLS: Final = (LOOK_ONCE, VIEWS_ONLY, EVERYTHING, ALWAYS_DEFER)
ORACLE: Final = "truth-oracle"
THRESHOLDS: Final = tuple(n / 20 for n in range(20))


def succeeds(walked: Walked, action: str, body: str, p: float) -> bool:
    """Whether this action on this body works the first time that anybody tries it here."""
    rng = stream(walked.recording.family, walked.recording.seed, "outcome", action, body, 1)
    return bool(rng.random() < p)


def play(control: Control, walked: Walked, cell: Cell) -> Scored:
    """One episode of a control. A failed interaction ends it."""
    path = control.path(walked, cell)
    for name in path:
        kind = cell.inform(name).kind
        if not succeeds(walked, name, "-", P_REMOVE if kind == "remove_cover" else P_VIEW):
            return _scored(walked, "interaction_failed", path, cell)
    look = walked.walks[path][-1]
    best = best_grasp(look.reply.belief, walked.recording.target.relation)
    if best is None or best[1] < control.grasps_above:
        absent = walked.truth.target is None
        return _scored(walked, "success" if absent else "false_defer", path, cell)
    return _scored(walked, _grasp(walked, look.bodies.get(best[0])), path, cell)


def best_grasp(belief: Mapping[str, float], asked: str) -> tuple[int, float] | None:
    """The track of the most probable hypothesis that the instruction allows, and its belief."""
    compatible = [
        (parsed[0], p)
        for name, p in belief.items()
        if (parsed := parse_tracked(name)) is not None and asked in ("any", parsed[1])
    ]
    return max(compatible, key=lambda pair: pair[1], default=None)


def play_oracle(walked: Walked, cell: Cell) -> Scored:
    """Knows the target: opens only when it lies under the cover, and suffers only execution."""
    truth, covered = walked.truth, walked.recording.covered
    if truth.target is None:
        return _scored(walked, "success", (), cell)
    opening = [r.name for r in cell.informs if r.kind == "remove_cover"][:1]
    path: Path = tuple(opening) if covered and truth.relation == "inside" else ()
    if path and not succeeds(walked, path[0], "-", P_REMOVE):
        return _scored(walked, "interaction_failed", path, cell)
    return _scored(walked, _grasp(walked, truth.target), path, cell)


def _grasp(walked: Walked, body: str | None) -> Verdict:
    if body is None or body != walked.truth.target:
        return "wrong_object"
    return "success" if succeeds(walked, "grasp", body, P_GRASP) else "grasp_failed"


def _scored(walked: Walked, verdict: Verdict, path: Path, cell: Cell) -> Scored:
    cost = sum(cell.inform(name).cost for name in path)
    recording = walked.recording
    return Scored(recording.family, recording.seed, verdict, len(path) + 1, cost)


def play_all(scenes: Sequence[Walked], cell: Cell) -> dict[str, list[Scored]]:
    """All controls and the oracle on all scenes; thresholds chosen for the control's advantage."""
    played = {
        control.name: _at_its_best(control, scenes, cell)
        if 0.0 < control.grasps_above < 1.0
        else [play(control, scene, cell) for scene in scenes]
        for control in CONTROLS
    }
    return played | {ORACLE: [play_oracle(scene, cell) for scene in scenes]}


def _at_its_best(control: Control, scenes: Sequence[Walked], cell: Cell) -> list[Scored]:
    """A gate from above is passed honestly only against the best threshold."""
    tried = [
        [play(Control(control.name, control.path, tau), scene, cell) for scene in scenes]
        for tau in THRESHOLDS
    ]
    return max(tried, key=lambda episodes: share(episodes))


def share(episodes: Iterable[Scored], family: str | None = None) -> float:
    """The share of successes, of one family or of all; 0 of nothing."""
    chosen = [e for e in episodes if family in (None, e.family)]
    return sum(e.verdict == "success" for e in chosen) / len(chosen) if chosen else 0.0


@dataclass(frozen=True)
class Gate:
    """A bound that the generator must keep."""

    control: str
    family: str | None
    low: float
    high: float
    found: float

    @property
    def passed(self) -> bool:
        """Within the bounds, which belong to it."""
        return self.low - 1e-12 <= self.found <= self.high + 1e-12


def judge(played: Mapping[str, Sequence[Scored]]) -> list[Gate]:
    """All gates, with what was found."""
    bounds: tuple[tuple[str, str | None, float, float], ...] = (
        (LOOK_ONCE.name, None, 0.0, 0.55),
        (LOOK_ONCE.name, "partial", 0.0, 0.65),
        (LOOK_ONCE.name, "ambiguous", 0.0, 0.65),
        (VIEWS_ONLY.name, None, 0.0, 0.70),
        (EVERYTHING.name, None, 0.0, 0.88),
        (ALWAYS_DEFER.name, None, 0.20, 0.20),
        (ORACLE, None, 0.90, 1.0),
    )
    return [
        Gate(control, family, low, high, share(played[control], family))
        for control, family, low, high in bounds
    ]
