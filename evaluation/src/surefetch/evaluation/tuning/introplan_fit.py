"""Lessons to what IntroPlan knows: situations, a fitted model, and scores of calibration episodes.

Only this needs scikit-learn; what it fits is kept as plain arrays, which numpy alone evaluates.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from surefetch.common.errors import BadInput
from surefetch.evaluation.policies.introplan_chances import CHANCES, STRONG, miss
from surefetch.evaluation.policies.introplan_knowledge import (
    DEPTH,
    FOLDS,
    NO_FOLD,
    Forests,
    Knowledge,
    Origin,
    fold_of,
)
from surefetch.evaluation.policies.introplan_situation import OPTIONS, features
from surefetch.evaluation.tuning.introplan_lessons import Lesson

ROUNDS: Final = 100
LEARNING_RATE: Final = 0.1
SHARE: Final = 0.5
"""Of the situations that each tree sees."""
NEVER: Final = -50.0
"""Score of an option that was right in no situation."""
INNER: Final = 2**DEPTH - 1


@dataclass(frozen=True, eq=False)
class Table:
    """Lessons as arrays."""

    situations: NDArray[np.float64]
    """(m, features)"""
    right: NDArray[np.bool_]
    """(m, options)"""
    fold: NDArray[np.uint8]
    """(m,)"""


def table_of(scenes: Mapping[tuple[str, int], Sequence[Lesson]]) -> Table:
    """The lessons of all scenes."""
    rows = [(seed, lesson) for (_, seed), lessons in scenes.items() for lesson in lessons]
    return Table(
        np.array([features(lesson.met.now, lesson.met.view) for _, lesson in rows]),
        np.array([lesson.right for _, lesson in rows]),
        np.array([fold_of(seed) for seed, _ in rows], np.uint8),
    )


def fit_forests(table: Table) -> Forests:
    """One forest without each fold, and the temperature that suits what they were not fitted on.

    Raises:
        BadInput: scikit-learn is missing, or a fold holds nothing.
    """
    parts = [_fit_one(table, table.fold != fold) for fold in range(FOLDS)]
    feature, threshold, leaf = (np.stack(part) for part in zip(*parts, strict=True))
    forests = Forests(feature, threshold, leaf, temperature=1.0)
    return replace(forests, temperature=_best_temperature(forests, table))


def learned(origin: Origin, table: Table, calibration: Sequence[Sequence[Lesson]]) -> Knowledge:
    """Everything that ships for one belief.

    Args:
        origin: of all of it.
        table: of development scenes.
        calibration: the lessons of each calibration episode, the first look's first.
    """
    known = Knowledge(
        origin, table.situations, table.right, table.fold, fit_forests(table), scores={}
    )
    scores = {
        variant: np.array(
            [
                [_score(variant, lessons, known, fold) for lessons in calibration]
                for fold in range(NO_FOLD + 1)
            ]
        )
        for variant in CHANCES
    }
    return replace(known, scores=scores)


def _score(variant: str, lessons: Sequence[Lesson], known: Knowledge, held_out: int) -> float:
    """How little an episode makes of what is right.

    Of the strong variant it is the worst of all situations that a sequence of looks leads to,
    because which of them an episode comes by depends on the threshold.
    """
    chances = CHANCES[variant]
    counted = lessons if variant == STRONG else lessons[:1]
    return max(
        miss(chances(one.met.now, one.met.view, known, held_out), one.right) for one in counted
    )


def _fit_one(table: Table, chosen: NDArray[np.bool_]) -> tuple[NDArray[Any], ...]:
    """Feature, threshold and leaf of a forest; each option that is right is a case of its own."""
    row, option = np.nonzero(table.right & chosen[:, None])
    if len(np.unique(option)) < 2:
        raise BadInput("too few development scenes to learn from: record more.")
    weight = 1.0 / table.right[row].sum(axis=1)
    forest = _ensemble().GradientBoostingClassifier(
        n_estimators=ROUNDS, learning_rate=LEARNING_RATE, max_depth=DEPTH, subsample=SHARE,
        init="zero", random_state=0,
    ).fit(table.situations[row], option, sample_weight=weight)  # fmt: skip
    return _as_arrays(forest)


def _as_arrays(forest: Any) -> tuple[NDArray[Any], ...]:
    """See `Forests`."""
    shape = (ROUNDS, len(OPTIONS))
    feature = np.zeros((*shape, INNER), np.uint8)
    threshold = np.full((*shape, INNER), np.inf, np.float32)
    leaf = np.full((*shape, INNER + 1), NEVER / (ROUNDS * LEARNING_RATE), np.float32)
    options = [int(option) for option in forest.classes_]
    for r, trees in enumerate(forest.estimators_):
        pairs = zip(_scored(options), trees, strict=True)
        for option, tree in pairs:
            _fill(tree.tree_, feature[r, option], threshold[r, option], leaf[r, option])
    if len(options) == 2:  # one tree a round then tells the second from the first
        leaf[:, options[0]] = 0.0
    return feature, threshold, LEARNING_RATE * leaf


def _scored(options: Sequence[int]) -> Sequence[int]:
    return options[1:] if len(options) == 2 else options


def _fill(
    tree: Any,
    feature: NDArray[np.uint8],
    threshold: NDArray[np.float32],
    leaf: NDArray[np.float32],
) -> None:
    """Lay a tree out as a complete one; below an early leaf everything goes to the left."""

    def lay(node: int, at: int) -> None:
        if at >= INNER:
            leaf[at - INNER] = tree.value[node].item()
            return
        early = tree.children_left[node] < 0
        if not early:
            feature[at], threshold[at] = tree.feature[node], tree.threshold[node]
        lay(node if early else tree.children_left[node], 2 * at + 1)
        lay(node if early else tree.children_right[node], 2 * at + 2)

    lay(0, 0)


def _best_temperature(forests: Forests, table: Table) -> float:
    """Under which what is right has the best log score by the forest that did not see it."""
    scores = np.array(
        [
            forests.scores(situation)[fold]
            for situation, fold in zip(table.situations, table.fold, strict=True)
        ]
    )

    def loss(log_temperature: float) -> float:
        z = scores / np.exp(log_temperature)
        z -= z.max(axis=1, keepdims=True)
        p = np.exp(z) / np.exp(z).sum(axis=1, keepdims=True)
        share = table.right / table.right.sum(axis=1, keepdims=True)
        return -float((share * np.log(np.maximum(p, 1e-12))).sum(axis=1).mean())

    found = minimize_scalar(loss, bounds=(-2.0, 2.0), method="bounded")
    return float(np.exp(found.x))


def _ensemble() -> Any:
    try:
        return import_module("sklearn.ensemble")
    except ImportError:
        raise BadInput(
            "fitting IntroPlan needs scikit-learn, which is not installed here.\n"
            '  Install it: pip install "surefetch-evaluation[baselines]"'
        ) from None
