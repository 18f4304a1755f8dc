"""The joint belief, step by step: first belief, birth, floor, tempered product, normalise. Pure."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.belief.evidence import NOTHING, Evidence, Known, Seen
from surefetch.belief.first_belief import birth, initial
from surefetch.common.joint_belief import JointBelief, factorized, normalised
from surefetch.common.parameters import PAPER_TEMPERING, BeliefPriors, BirthCounts

Array = NDArray[np.float64]

FLOOR: Final = 1e-300

Births = Callable[[str, bool], BirthCounts | None]
"""What was counted of looks under a viewing condition and cover state, where anything was."""


@dataclass(frozen=True, eq=False)
class Memory:
    """What the filter carries from step to step. `belief` is None before the first."""

    belief: JointBelief | None = None
    n_observations: Mapping[int, int] = field(default_factory=dict)
    """Counted observations by track."""
    known: Mapping[int, Known] = field(default_factory=dict)
    """What the evidence has learnt of each observed track."""
    counted_ids: frozenset[str] = frozenset()


@dataclass(frozen=True, eq=False)
class Step:
    """What one step made of the memory."""

    memory: Memory
    belief: JointBelief
    prior: JointBelief
    """After first belief or birth, before the floor and the likelihoods."""
    counted: tuple[bool, ...]
    """For each detection."""


@dataclass(frozen=True, eq=False)
class Model:
    """The numbers and switches of the filter."""

    evidence: Evidence
    priors: BeliefPriors
    """Where the container is open."""
    tempering: float = PAPER_TEMPERING
    """γ: the n-th observation of a track counts with exponent n^-γ."""
    factorized: bool = False
    covered_priors: BeliefPriors | None = None
    """Where it is covered; None: the same."""
    births: Births | None = None
    """What new tracks, and none, say of a target without a track; None: the paper's rule."""


def step(
    memory: Memory,
    tracks: Sequence[int],
    seen: Sequence[Seen],
    q: str,
    model: Model,
    *,
    covered: bool = False,
    look_counts: bool = True,
) -> Step:
    """One step: tracks, then first belief or birth, then the observations that count.

    Args:
        memory: after the step before.
        tracks: ids of all tracks that exist after this step's association, increasing.
        seen: this step's detections, in order.
        q: viewing condition.
        model: evidence, priors and switches.
        covered: whether the container is covered in this look.
        look_counts: False for a look that was counted before: no new evidence of what it does
            not show.

    Source: paper, eq:initial-belief, eq:track-birth, eq:runtime-belief-update.
    """
    priors = model.covered_priors if covered and model.covered_priors else model.priors
    if memory.belief is None:
        prior = initial(tuple(tracks), priors)
    else:
        births = model.births(q, covered) if model.births and look_counts else None
        prior = birth(memory.belief, tuple(tracks), priors, births)
    counted = which_count(seen, memory.counted_ids)
    fresh = [s for s, counts in zip(seen, counted, strict=True) if counts]
    weigh = model.evidence.under(q)
    weighed = {s.track: weigh(s, memory.known.get(s.track, NOTHING)) for s in fresh}
    n_observations = dict(memory.n_observations) | {
        i: memory.n_observations.get(i, 0) + 1 for i in weighed
    }
    likelihoods = {
        i: (w.likelihood, n_observations[i] ** -model.tempering) for i, w in weighed.items()
    }
    absence = math.prod(
        w.absence ** (n_observations[i] ** -model.tempering) for i, w in weighed.items()
    )
    belief = update(prior, likelihoods, absence)
    if model.factorized:
        belief = replace(belief, p_tracked=factorized(belief.p_tracked))
    return Step(
        Memory(
            belief,
            n_observations,
            dict(memory.known) | {i: w.known for i, w in weighed.items()},
            memory.counted_ids | {s.id for s in fresh},
        ),
        belief,
        prior,
        counted,
    )


def which_count(seen: Sequence[Seen], counted_before: frozenset[str]) -> tuple[bool, ...]:
    """For each detection whether it counts: one per track and step, no id ever twice."""
    ids, tracks = set(counted_before), set()
    counted = []
    for s in seen:
        counts = s.y is not None and s.id not in ids and s.track not in tracks
        if counts:
            ids.add(s.id)
            tracks.add(s.track)
        counted.append(counts)
    return tuple(counted)


def update(
    prior: JointBelief, likelihoods: Mapping[int, tuple[Array, float]], absence: float = 1.0
) -> JointBelief:
    """Floor, multiply by the tempered likelihoods, normalise.

    Every observation has the distractor likelihood under all hypotheses but its own track's, so
    only the ratios to it are multiplied: the rest cancels in the normaliser, and nothing
    underflows.

    Args:
        prior: b⁻.
        likelihoods: by observed track, (classes,) of its observation with the distractor last,
            and the exponent that tempers it.
        absence: how much likelier all observations are if the target is absent than if each is of
            a distractor beside it; 1 in the paper.

    Source: paper, eq:runtime-belief-update.
    """
    p_tracked = np.maximum(prior.p_tracked, FLOOR)
    for i, (by_class, exponent) in likelihoods.items():
        p_tracked[prior.tracks.index(i)] *= (by_class[:-1] / by_class[-1]) ** exponent
    p_unobs, p_abs = max(prior.p_unobs, FLOOR), max(prior.p_abs, FLOOR) * absence
    return normalised(JointBelief(prior.tracks, p_tracked, p_unobs, p_abs))
