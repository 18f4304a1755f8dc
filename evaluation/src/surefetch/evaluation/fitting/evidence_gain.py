"""What each switch of `extended` is worth on development scenes that it was not fitted on. Pure."""

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from surefetch.common.parameters import Parameters
from surefetch.evaluation.fitting.evidence_switches import SWITCHES, turned_on
from surefetch.evaluation.recordings.story import Story, log_score

Fit = Callable[[Sequence[Story]], Parameters]
"""Parameters with all switches off."""
Scene = tuple[str, int]
Scores = Mapping[Scene, float]
"""log b(z*), the mean over the looks, by family and seed."""


@dataclass(frozen=True)
class Gain:
    """Of log b(z*), paired by scene."""

    mean: float
    standard_error: float
    better: int
    worse: int

    def __str__(self) -> str:
        return (
            f"{self.mean:+.3f} ± {self.standard_error:.3f} ({self.better} better, "
            f"{self.worse} worse)"
        )


@dataclass(frozen=True)
class Worth:
    """What the switches are worth, each half of the seeds scored with numbers of the other."""

    n: int
    none: float
    """Mean log score with all off."""
    all_on: float
    alone: Mapping[str, Gain]
    """By switch: only this one on, over none."""
    on_top: Mapping[str, Gain]
    """By switch: all on, over all but this one."""


def worth(stories: Sequence[Story], fit_off: Fit) -> Worth:
    """Cross-validated by even and odd seeds.

    Raises:
        ValueError: one of the halves is empty.
    """
    everything = frozenset(SWITCHES)
    variants = {frozenset(), everything}
    variants |= {frozenset({one}) for one in SWITCHES} | {everything - {one} for one in SWITCHES}
    scores = {on: crossed(stories, fit_off, on) for on in variants}
    none, all_on = scores[frozenset()], scores[everything]
    return Worth(
        n=len(none),
        none=statistics.fmean(none.values()),
        all_on=statistics.fmean(all_on.values()),
        alone={one: gain(scores[frozenset({one})], none) for one in SWITCHES},
        on_top={one: gain(all_on, scores[everything - {one}]) for one in SWITCHES},
    )


def crossed(stories: Sequence[Story], fit_off: Fit, on: frozenset[str]) -> Scores:
    """Scores with these switches on: fitted on even seeds, scored on odd ones, and the reverse."""
    halves = [[s for s in stories if s.seed % 2 == parity] for parity in (0, 1)]
    if not all(halves):
        raise ValueError("scenes of even and of odd seeds are needed to compare")
    scores: dict[Scene, float] = {}
    for fitted_on, scored in (halves, reversed(halves)):
        parameters = turned_on(fit_off(fitted_on), fitted_on, on)
        scores |= {(s.family, s.seed): log_score(s, parameters) for s in scored}
    return scores


def gain(with_it: Scores, without: Scores) -> Gain:
    """The paired difference of two scores of the same scenes."""
    differences = [with_it[scene] - without[scene] for scene in without]
    spread = statistics.stdev(differences) if len(differences) > 1 else math.inf
    return Gain(
        mean=statistics.fmean(differences),
        standard_error=spread / math.sqrt(len(differences)),
        better=sum(d > 0.0 for d in differences),
        worse=sum(d < 0.0 for d in differences),
    )


def table(found: Worth) -> str:
    """The comparison for people."""
    width = max(map(len, SWITCHES))
    rows = [
        f"  {one.ljust(width)}  alone {found.alone[one]}; on top of the others {found.on_top[one]}"
        for one in SWITCHES
    ]
    return "\n".join(
        [
            f"Mean log b(z*) over all looks at {found.n} scenes, each half of the seeds with "
            f"numbers of the other: {found.none:.3f} with all switches off, {found.all_on:.3f} "
            f"with all on.",
            "Gain of each switch (mean ± standard error):",
            *rows,
        ]
    )
