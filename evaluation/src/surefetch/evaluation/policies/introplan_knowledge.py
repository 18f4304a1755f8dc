"""What IntroPlan learned: situations with the options that were right in them, and a fitted model.

One file for each belief, without objects in it, so that reading it runs nothing. Situations come
from development scenes in folds, and can be had without those of one fold. What the conformal
threshold is drawn from comes from calibration scenes.
"""

import io
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from importlib import resources
from pathlib import Path
from typing import Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from surefetch.common.conformal import quantile
from surefetch.common.errors import BadInput
from surefetch.common.parameters import Provenance
from surefetch.evaluation.policies.introplan_situation import OPTIONS, Mask, Vector

FOLDS: Final = 5
DEPTH: Final = 3
NO_FOLD: Final = FOLDS
"""In the place of a fold: everything was learned from."""


def fold_of(seed: int) -> int:
    """The fold of a scene. Scenes of one seed share it, whatever their family."""
    return seed % FOLDS


class Origin(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Where the knowledge comes from."""

    profile: str
    parameters: str
    """Hash of the fitted numbers of the belief."""
    features: tuple[str, ...]
    lessons: Provenance
    calibration: Provenance
    command: str


@dataclass(frozen=True, eq=False)
class Forests:
    """Gradient-boosted trees of depth `DEPTH`, one forest for each fold that it was fitted without.

    Letters: f folds, r rounds, o options, n = 2^DEPTH - 1 inner nodes, l = n + 1 leaves.
    """

    feature: NDArray[np.uint8]
    """(f, r, o, n)"""
    threshold: NDArray[np.float32]
    """(f, r, o, n); above it, a situation goes to the right."""
    leaf: NDArray[np.float32]
    """(f, r, o, l), added to the score of the option"""
    temperature: float
    """Scores are divided by it, so that probabilities are calibrated."""

    def scores(self, situation: Vector) -> NDArray[np.float64]:
        """(f, o), before calibration."""
        at = np.zeros(self.feature.shape[:3], np.intp)  # (f, r, o)
        values = situation.astype(np.float32)
        for _ in range(DEPTH):
            feature = np.take_along_axis(self.feature, at[..., None], axis=-1)[..., 0]
            threshold = np.take_along_axis(self.threshold, at[..., None], axis=-1)[..., 0]
            at = 2 * at + 1 + (values[feature] > threshold)
        leaf = np.take_along_axis(self.leaf, at[..., None] - self.feature.shape[-1], axis=-1)
        found: NDArray[np.float64] = leaf[..., 0].sum(axis=1, dtype=np.float64)
        return found

    def p(self, situation: Vector, held_out: int) -> Vector:
        """(options,): by the forest without a fold, or by all together."""
        scores = self.scores(situation) / self.temperature
        p = np.exp(scores - scores.max(axis=1, keepdims=True))
        p /= p.sum(axis=1, keepdims=True)
        mean: Vector = p.mean(axis=0) if held_out == NO_FOLD else p[held_out]
        return mean


@dataclass(frozen=True, eq=False)
class Knowledge:
    """Everything that the variants of IntroPlan know beforehand."""

    origin: Origin
    situations: NDArray[np.float64]
    """(m, features)"""
    right: Mask
    """(m, options)"""
    fold: NDArray[np.uint8]
    """(m,)"""
    forests: Forests
    scores: Mapping[str, NDArray[np.float64]]
    """By variant, (folds + 1, calibration episodes): how little an episode made of what was right;
    row `NO_FOLD` with all that was learned."""

    @cached_property
    def _spread(self) -> Vector:
        """(features,): standard deviation of each; 1 where all are equal."""
        spread = self.situations.std(axis=0)
        return np.where(spread == 0.0, 1.0, spread)

    @cached_property
    def _scaled(self) -> NDArray[np.float64]:
        return self.situations / self._spread

    def votes(self, situation: Vector, k: int, held_out: int) -> Vector:
        """(options,): how often each was right in the k situations that are most alike."""
        distance = ((self._scaled - situation / self._spread) ** 2).sum(axis=1)
        distance[self.fold == held_out] = np.inf
        nearest = np.argsort(distance, kind="stable")[:k]
        share: Vector = self.right[nearest].mean(axis=0)
        return share

    def q_hat(self, variant: str, target: float, held_out: int) -> float:
        """The conformal threshold at which a set holds what is right in this share of episodes."""
        return quantile(list(self.scores[variant][held_out]), 1 - Fraction(f"{target:g}"))


@cache
def shipped(profile: str) -> Knowledge:
    """The knowledge that ships for the belief of a profile.

    Raises:
        BadInput: there is none.
    """
    name = name_of(profile)
    file = resources.files("surefetch.evaluation.policies").joinpath(f"tuned/{name}")
    if not file.is_file():
        raise BadInput(
            f'IntroPlan knows nothing for the belief of profile "{profile}".\n'
            "  Let it learn: surefetch study fit-introplan"
        )
    return parse(file.read_bytes(), name)


def name_of(profile: str) -> str:
    """The file for the belief of a profile."""
    return f"introplan-knowledge@{profile}.npz"


def write(folder: Path, knowledge: Knowledge) -> Path:
    """Write the file into a folder. Situations are kept to three digits."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name_of(knowledge.origin.profile)
    forests = knowledge.forests
    np.savez_compressed(
        path,
        origin=np.frombuffer(msgspec.json.encode(knowledge.origin), np.uint8),
        situations=knowledge.situations.astype(np.float16),
        right=np.packbits(knowledge.right, axis=1),
        fold=knowledge.fold,
        feature=forests.feature,
        threshold=forests.threshold,
        leaf=forests.leaf,
        temperature=np.float64(forests.temperature),
        variants=np.array(sorted(knowledge.scores)),
        scores=np.stack([knowledge.scores[name] for name in sorted(knowledge.scores)]),
    )
    return path


def parse(content: bytes, origin: str) -> Knowledge:
    """Knowledge from the bytes of a file. Raises BadInput naming it when it is damaged."""
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            found = {name: file[name] for name in file.files}
        return Knowledge(
            origin=msgspec.json.decode(found["origin"].tobytes(), type=Origin),
            situations=found["situations"].astype(np.float64),
            right=np.unpackbits(found["right"], axis=1, count=len(OPTIONS)).astype(bool),
            fold=found["fold"],
            forests=Forests(
                found["feature"], found["threshold"], found["leaf"], float(found["temperature"])
            ),
            scores=dict(zip(found["variants"].tolist(), found["scores"], strict=True)),
        )
    except (OSError, ValueError, KeyError, msgspec.DecodeError) as error:
        raise BadInput(f"{origin} is damaged: {error}\n  Fit it again.") from None
