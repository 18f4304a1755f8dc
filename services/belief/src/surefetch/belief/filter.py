"""The joint belief, step by step: first belief, birth, floor, tempered product, normalise. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from surefetch.belief.evidence import NOTHING, Evidence, Known, Seen
from surefetch.common.hypotheses import RELATIONS
from surefetch.common.joint_belief import JointBelief, factorized
from surefetch.common.parameters import PAPER_TEMPERING, BeliefPriors

Array = NDArray[np.float64]

FLOOR: Final = 1e-300


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
    tempering: float = PAPER_TEMPERING
    """γ: the n-th observation of a track counts with exponent n^-γ."""
    factorized: bool = False


def step(memory: Memory, tracks: Sequence[int], seen: Sequence[Seen], q: str, model: Model) -> Step:
    """One step: tracks, then first belief or birth, then the observations that count.

    Args:
        memory: after the step before.
        tracks: ids of all tracks that exist after this step's association, increasing.
        seen: this step's detections, in order.
        q: viewing condition.
        model: evidence, priors and switches.

    Source: paper, eq:initial-belief, eq:track-birth, eq:runtime-belief-update.
    """
    prior = _prior(memory.belief, tuple(tracks), model.priors)
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
    belief = update(prior, likelihoods)
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


def initial(tracks: tuple[int, ...], priors: BeliefPriors) -> JointBelief:
    """b0, from the tracks of the first tracking pass.

    Source: paper, eq:initial-belief.
    """
    if not tracks:
        none = np.empty((0, len(RELATIONS)))
        return JointBelief((), none, priors.unobserved + priors.tracked, priors.absent)
    p_tracked = np.tile(priors.tracked / len(tracks) * _pi(priors), (len(tracks), 1))
    return JointBelief(tracks, p_tracked, priors.unobserved, priors.absent)


def birth(belief: JointBelief, tracks: tuple[int, ...], priors: BeliefPriors) -> JointBelief:
    """New tracks take their share of unobs; nothing else moves.

    Source: paper, eq:track-birth.
    """
    fresh = [i for i in tracks if i not in belief.tracks]
    if not fresh:
        return belief
    share = priors.birth * belief.p_unobs / len(fresh)
    known = dict(zip(belief.tracks, belief.p_tracked, strict=True))
    p_tracked = np.array([known.get(i, share * _pi(priors)) for i in tracks])
    return JointBelief(tracks, p_tracked, (1.0 - priors.birth) * belief.p_unobs, belief.p_abs)


def update(prior: JointBelief, likelihoods: Mapping[int, tuple[Array, float]]) -> JointBelief:
    """Floor, multiply by the tempered likelihoods, normalise.

    Every observation has the distractor likelihood under all hypotheses but its own track's, so
    only the ratios to it are multiplied: the rest cancels in the normaliser, and nothing
    underflows.

    Args:
        prior: b⁻.
        likelihoods: by observed track, (classes,) of its observation with the distractor last,
            and the exponent that tempers it.

    Source: paper, eq:runtime-belief-update.
    """
    p_tracked = np.maximum(prior.p_tracked, FLOOR)
    for i, (by_class, exponent) in likelihoods.items():
        p_tracked[prior.tracks.index(i)] *= (by_class[:-1] / by_class[-1]) ** exponent
    p_unobs, p_abs = max(prior.p_unobs, FLOOR), max(prior.p_abs, FLOOR)
    total = p_tracked.sum() + p_unobs + p_abs
    return JointBelief(prior.tracks, p_tracked / total, p_unobs / total, p_abs / total)


def _prior(
    belief: JointBelief | None, tracks: tuple[int, ...], priors: BeliefPriors
) -> JointBelief:
    return initial(tracks, priors) if belief is None else birth(belief, tracks, priors)


def _pi(priors: BeliefPriors) -> Array:
    """π_R in the order of the relations."""
    return np.array([priors.relation[relation] for relation in RELATIONS])
