"""Episodes of one configuration, counted. Pure."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from surefetch.evaluation.policies.tuning import Trial
from surefetch.evaluation.recordings.splits import FAMILIES
from surefetch.evaluation.replaying.results import EpisodeResult


@dataclass(frozen=True)
class Tally:
    """What came of all episodes so far."""

    n: int = 0
    successes: Counter[str] = field(default_factory=Counter)
    """By family."""
    realized_cost: float = 0.0
    """Sum."""

    def and_one(self, episode: EpisodeResult) -> "Tally":
        """With one more."""
        won = Counter({episode.family: int(episode.verdict == "success")})
        return self.plus(Tally(1, won, episode.realized_cost))

    def plus(self, other: "Tally") -> "Tally":
        """Both together."""
        return Tally(
            self.n + other.n,
            self.successes + other.successes,
            self.realized_cost + other.realized_cost,
        )

    @property
    def n_successes(self) -> int:
        """Of all families."""
        return self.successes.total()

    @property
    def rank(self) -> tuple[int, float]:
        """The lower the better: more successes, then less realised cost."""
        return -self.n_successes, self.realized_cost

    def trial(self, values: Mapping[str, float]) -> Trial:
        """As the ledger holds it."""
        return Trial(
            values=dict(values),
            n_successes=self.n_successes,
            by_family={name: self.successes[name] for name in FAMILIES},
            mean_realized_cost=round(self.realized_cost / self.n, 6) if self.n else 0.0,
        )
