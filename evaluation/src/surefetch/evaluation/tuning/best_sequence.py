"""The one sequence of looks that goes best, for each cover state and asked relation. Pure.

A sequence is played twice on each scene: once grasping whatever is most probable at its end, and
once deferring. Every threshold takes one of the two ends.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from surefetch.common.cell import Cell
from surefetch.evaluation.policies.fixed_sequence import situation_of
from surefetch.evaluation.policies.tuning import Trial
from surefetch.evaluation.recordings.recording import Path, paths
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.tuning.tally import Tally


@dataclass(frozen=True)
class Ends:
    """How a sequence ended on a scene, when it grasped and when it deferred."""

    sequence: Path
    grasped: EpisodeResult
    deferred: EpisodeResult

    def at(self, at_least: float) -> EpisodeResult:
        """The end under a threshold."""
        return self.deferred if self.grasped.commit_p < at_least else self.grasped


def ends_of(
    one: Contender, episodes: Sequence[EpisodeResult], *, covered: bool, cell: Cell
) -> list[Ends]:
    """What came of `hindsight.all_ways`, by sequence."""
    admitted = paths(covered, cell, views_while_covered=one.profile.views_while_covered)
    pairs = zip(episodes[::2], episodes[1::2], strict=True)
    return [Ends(path, *pair) for path, pair in zip(admitted, pairs, strict=True)]


@dataclass(frozen=True, eq=False)
class Chosen:
    """The best sequences under one threshold."""

    trial: Trial
    sequences: Mapping[str, Path]
    successes: Mapping[str, Mapping[str, int]]
    """By what a sequence is for and its actions."""


def choose(scenes: Iterable[Sequence[Ends]], thresholds: Iterable[float]) -> Iterator[Chosen]:
    """For each threshold the best sequences, and what comes of them together."""
    groups: dict[str, list[Sequence[Ends]]] = {}
    for ends in scenes:
        first = ends[0].grasped
        groups.setdefault(situation_of(first.covered, first.asked), []).append(ends)
    for at_least in thresholds:
        tallies = {name: _tallies(of, at_least) for name, of in sorted(groups.items())}
        best = {name: _best(of) for name, of in tallies.items()}
        together = Tally()
        for name, path in best.items():
            together = together.plus(tallies[name][path])
        successes = {
            name: {" ".join(path): tally.n_successes for path, tally in of.items()}
            for name, of in tallies.items()
        }
        yield Chosen(together.trial({"at_least": at_least}), best, successes)


def _best(tallies: Mapping[Path, Tally]) -> Path:
    return min(tallies, key=lambda path: tallies[path].rank)


def _tallies(scenes: Iterable[Sequence[Ends]], at_least: float) -> dict[Path, Tally]:
    tallies: dict[Path, Tally] = {}
    for ends in scenes:
        for end in ends:
            before = tallies.get(end.sequence, Tally())
            tallies[end.sequence] = before.and_one(end.at(at_least))
    return tallies
