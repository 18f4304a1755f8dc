"""How likely each option is to be right, by each variant of IntroPlan, and the set that is left."""

from collections.abc import Callable
from typing import Final

import numpy as np

from surefetch.common.hypotheses import ABS
from surefetch.evaluation.policies.introplan_knowledge import Knowledge
from surefetch.evaluation.policies.introplan_situation import (
    GRASP_FIRST,
    GRASP_SECOND,
    NOT_LISTED,
    OPTIONS,
    Mask,
    Vector,
    candidates,
    choices,
    features,
)
from surefetch.evaluation.policies.observation import Observation

K: Final = 3
TEMPERATURE: Final = 5.0
"""Both as published."""
EPSILON: Final = 1e-3
"""Keeps what no neighbour votes for from having no chance at all."""

Chances = Callable[[Observation, str, Knowledge, int], Vector]
"""(options,), of an observation, the view of the latest look, knowledge, and the fold held out."""


def by_neighbours(now: Observation, view: str, known: Knowledge, held_out: int) -> Vector:
    """What was right in the most similar situations; in the place of a language model."""
    return _softened(known.votes(features(now, view), K, held_out), now)


def by_model(now: Observation, view: str, known: Knowledge, held_out: int) -> Vector:
    """What the fitted model says."""
    return _over_open(known.forests.p(features(now, view), held_out), now)


def by_belief(now: Observation, _: str, __: Knowledge, ___: int) -> Vector:
    """Without knowledge: the belief in each option; what speaks for none of them is for looking."""
    masses = [one.p for one in candidates(now)[:2]] + [0.0, 0.0]
    weights = np.zeros(len(OPTIONS))
    weights[[GRASP_FIRST, GRASP_SECOND]] = masses[:2]
    weights[NOT_LISTED] = now.believed.belief[ABS]
    rest = max(0.0, 1.0 - weights.sum())
    return _softened(np.where(weights > 0.0, weights, rest), now)


STRONG: Final = "introplan-strong"
"""Its threshold rests on all situations of a calibration episode, that of the others on the first.
"""
LITE: Final = "introplan-lite"
KNOWNO: Final = "knowno"
CHANCES: Final[dict[str, Chances]] = {STRONG: by_model, LITE: by_neighbours, KNOWNO: by_belief}
"""By name of the policy."""


def open_options(now: Observation) -> Mask:
    """(options,): whether each is open."""
    return np.array([choice is not None for choice in choices(now)])


def likely(p: Vector, q_hat: float) -> list[int]:
    """The options that the conformal set holds; one that is not open has no chance."""
    return [o for o in range(len(OPTIONS)) if p[o] > 0.0 and 1.0 - p[o] <= q_hat]


def miss(p: Vector, right: Mask) -> float:
    """Nonconformity of a decision: 1 minus the chance of the likeliest option that is right."""
    return 1.0 - float(p[right].max(initial=0.0))


def _softened(weights: Vector, now: Observation) -> Vector:
    """Softmax of their logarithms at the published temperature."""
    return _over_open((weights + EPSILON) ** (1.0 / TEMPERATURE), now)


def _over_open(weights: Vector, now: Observation) -> Vector:
    chosen: Vector = np.where(open_options(now), weights, 0.0)
    chosen /= chosen.sum()
    return chosen
