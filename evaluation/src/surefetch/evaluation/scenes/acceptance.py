"""How many attempts at a scene the generator accepted, and why it rejected the others. Pure."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from surefetch.evaluation.scenes.truth import SceneTruth


@dataclass(frozen=True)
class Acceptance:
    """Of one family."""

    scenes: int
    attempts: int
    rejected: dict[str, int]
    """Attempts by reason, the commonest first."""

    @property
    def rate(self) -> float:
        """Accepted attempts over all."""
        return self.scenes / self.attempts


def by_family(truths: Iterable[SceneTruth]) -> dict[str, Acceptance]:
    """The account of each family that occurs."""
    grouped: dict[str, list[SceneTruth]] = {}
    for truth in truths:
        grouped.setdefault(truth.family, []).append(truth)
    return {family: _of(scenes) for family, scenes in grouped.items()}


def _of(scenes: list[SceneTruth]) -> Acceptance:
    rejected: Counter[str] = Counter()
    for scene in scenes:
        rejected.update(scene.rejected)
    attempts = sum(scene.attempts for scene in scenes)
    return Acceptance(len(scenes), attempts, dict(rejected.most_common()))
