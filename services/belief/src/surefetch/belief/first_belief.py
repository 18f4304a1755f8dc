"""What is believed of a hypothesis before its first answer: first belief and birth. Pure."""

import numpy as np
from numpy.typing import NDArray

from surefetch.common.hypotheses import RELATIONS
from surefetch.common.joint_belief import JointBelief, normalised
from surefetch.common.parameters import BeliefPriors, BirthCounts

Array = NDArray[np.float64]


def initial(tracks: tuple[int, ...], priors: BeliefPriors) -> JointBelief:
    """b0, from the tracks of the first tracking pass.

    Source: paper, eq:initial-belief.
    """
    if not tracks:
        none = np.empty((0, len(RELATIONS)))
        return JointBelief((), none, priors.unobserved + priors.tracked, priors.absent)
    p_tracked = np.tile(priors.tracked / len(tracks) * _pi(priors), (len(tracks), 1))
    return JointBelief(tracks, p_tracked, priors.unobserved, priors.absent)


def birth(
    belief: JointBelief,
    tracks: tuple[int, ...],
    priors: BeliefPriors,
    counts: BirthCounts | None = None,
) -> JointBelief:
    """New tracks take their share of unobs; nothing else moves.

    Without counts the share is β_birth, and no new track says nothing (the paper). With them, how
    many new tracks n a look gives is itself evidence. A target that has no track gets its first
    with probability d, and then n is drawn from A; otherwise, as under every other hypothesis, n is
    drawn from C, from whatever else comes into sight:

        P(n | z)                          = C(n)          z tracked before, or abs
        P(n, it is not among them | unobs) = (1 - d) C(n)
        P(n, it is among them | unobs)     = d A(n)        A(0) = 0, each of the n alike

    With C(n) taken out, unobs keeps (1 - d) and the new tracks take d A(n)/C(n) of it, before all
    is normalised. Looks that show nothing new so commute, each a factor on unobs.

    Source: paper, eq:track-birth; Koopman, Search and Screening (1946) for d;
    Mahler, Statistical Multisource-Multitarget Information Fusion (2007) for births and clutter.
    """
    fresh = [i for i in tracks if i not in belief.tracks]
    if not fresh and counts is None:
        return belief
    keeps, takes = _shares(len(fresh), priors, counts)
    share = takes * belief.p_unobs / max(1, len(fresh))
    known = dict(zip(belief.tracks, belief.p_tracked, strict=True))
    p_tracked = [known.get(i, share * _pi(priors)) for i in tracks]
    made = JointBelief(
        tracks,
        np.array(p_tracked).reshape(-1, len(RELATIONS)),
        keeps * belief.p_unobs,
        belief.p_abs,
    )
    return made if counts is None else normalised(made)


def _shares(n_new: int, priors: BeliefPriors, counts: BirthCounts | None) -> tuple[float, float]:
    """What unobs keeps of itself, and what the new tracks together take."""
    if counts is not None:
        d = counts.p_appears
        return 1.0 - d, d * counts.likelihood_ratio(n_new)
    return 1.0 - priors.birth, priors.birth


def _pi(priors: BeliefPriors) -> Array:
    """π_R in the order of the relations."""
    return np.array([priors.relation[relation] for relation in RELATIONS])
