"""Risk against coverage: how often a policy grasps wrongly when it grasps less readily. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from surefetch.common.hypotheses import parse_tracked
from surefetch.evaluation.replaying.results import EpisodeResult

SAME: Final = 1e-9


@dataclass(frozen=True)
class Point:
    """What one commit threshold would give."""

    threshold: float
    coverage: float
    """Share of the episodes with a target in which a grasp would be tried."""
    risk: float
    """Share of all tries that would be at another object."""


@dataclass(frozen=True)
class Commitment:
    """How sure one episode was of its grasp, and whether that was wrong."""

    p: float
    wrong: bool
    present: bool


def commitment(episode: EpisodeResult) -> Commitment | None:
    """What an episode grasped, or would have grasped at the end; None where nothing was open.

    The score is `commit_p`. An episode that tried to grasp is judged as the tables judge it. One
    that did not is judged by the hypothesis of that mass in its last belief, which is wrong when
    its track is not the target's.
    """
    if episode.grasps:
        wrong = episode.verdict == "wrong_object"
        return Commitment(episode.grasps[-1].p, wrong, episode.target_present)
    if episode.commit_p <= 0.0 or not episode.steps:
        return None
    end = episode.steps[-1]
    track = next((_track(z) for z, p in end.belief.items() if abs(p - episode.commit_p) < SAME), -1)
    return Commitment(episode.commit_p, track != _track(end.z_true), episode.target_present)


def curve(episodes: Sequence[EpisodeResult]) -> list[Point]:
    """From the strictest threshold at which anything is grasped to none at all."""
    found = sorted(
        (c for episode in episodes if (c := commitment(episode)) is not None), key=lambda c: -c.p
    )
    present = sum(episode.target_present for episode in episodes)
    if not present:
        return []
    points: list[Point] = []
    tried = wrong = covered = 0
    for n, one in enumerate(found):
        tried, wrong, covered = tried + 1, wrong + one.wrong, covered + one.present
        if n + 1 == len(found) or found[n + 1].p < one.p:
            points.append(Point(one.p, covered / present, wrong / tried))
    return points


def area(points: Sequence[Point]) -> float | None:
    """Mean risk over the coverages that are reached; None without a curve.

    Below the first point the risk is taken to be that of the first point.
    """
    if not points or points[-1].coverage == 0.0:
        return None
    total = points[0].risk * points[0].coverage
    for before, after in zip(points, points[1:], strict=False):
        total += (after.coverage - before.coverage) * (before.risk + after.risk) / 2.0
    return total / points[-1].coverage


def risk_at(points: Sequence[Point], coverage: float) -> float | None:
    """The risk at the strictest threshold that covers as much; None: none does."""
    return next((point.risk for point in points if point.coverage >= coverage), None)


def operating_point(episodes: Sequence[EpisodeResult]) -> tuple[float, float] | None:
    """Coverage and risk as they were; None where nothing was grasped or no target there."""
    tried = [episode for episode in episodes if episode.grasps]
    present = sum(episode.target_present for episode in episodes)
    if not tried or not present:
        return None
    wrong = sum(episode.verdict == "wrong_object" for episode in tried)
    return sum(episode.target_present for episode in tried) / present, wrong / len(tried)


def _track(hypothesis: str) -> int | None:
    parsed = parse_tracked(hypothesis)
    return None if parsed is None else parsed[0]
