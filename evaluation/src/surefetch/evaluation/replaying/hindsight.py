"""What looking could have come to at best, with this perception and this belief. No policy.

An episode succeeds if any admissible sequence of looks, followed by grasping what is most probable
or by deferring, succeeds. Which sequence and which end is told by the truth, afterwards.

Source: EVALUATION, controls.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import Final

from surefetch.common.cell import Cell
from surefetch.evaluation.policies.fixed_sequence import FixedSequence
from surefetch.evaluation.policies.registry import Entry
from surefetch.evaluation.recordings.recording import paths
from surefetch.evaluation.replaying.contenders import Contender
from surefetch.evaluation.replaying.results import EpisodeResult

GRASPS: Final = 0.0
"""A threshold under which the most probable is always grasped."""
DEFERS: Final = 2.0
"""One under which nothing is."""

Play = Callable[[Iterable[Contender]], Iterable[EpisodeResult]]


def all_ways(one: Contender, *, covered: bool, cell: Cell) -> list[Contender]:
    """This contender along every sequence that its rules admit, first grasping, then deferring."""
    admitted = paths(covered, cell, views_while_covered=one.profile.views_while_covered)
    return [
        replace(one, entry=Entry(partial(FixedSequence, sequence, at_least)))
        for sequence in admitted
        for at_least in (GRASPS, DEFERS)
    ]


def best_of(episodes: Sequence[EpisodeResult]) -> EpisodeResult:
    """One that succeeds, if any does; of equals the cheapest, of equals again the first."""
    return min(episodes, key=lambda e: (e.verdict != "success", e.realized_cost))


def best_way(ways: Sequence[Contender], play: Play, play_to_the_end: Play) -> EpisodeResult:
    """The best of all ways.

    Args:
        ways: see `all_ways`.
        play: plays within the recording.
        play_to_the_end: also finishes what leaves it, which takes long; asked only where nothing
            else succeeds.
    """
    episodes = list(play(ways))
    left = [way for way, e in zip(ways, episodes, strict=True) if e.verdict == "aborted"]
    if left and best_of(episodes).verdict != "success":
        episodes += play_to_the_end(left)
    return best_of(episodes)
