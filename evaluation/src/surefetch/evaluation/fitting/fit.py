"""Walked development scenes to the observation model, its future twin, and the priors. Pure."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Final

from surefetch.common.hypotheses import ABS, CLASSES, OBSERVATIONS, UNOBS
from surefetch.evaluation.fitting.fit_births import NewTracks, new_tracks
from surefetch.evaluation.recordings.walk import Look

Walks = Mapping[tuple[str, ...], Sequence[Look]]
"""The looks of one scene, by sequence of information actions."""

DISTRACTOR: Final = CLASSES[2]


@dataclass(frozen=True, eq=False)
class Counts:
    """What was counted over scenes; sums of two are sums of their entries."""

    emission: Counter[tuple[str, str, str]] = field(default_factory=Counter)
    """N(q, c, y)"""
    paired: Counter[tuple[str, str, str, str]] = field(default_factory=Counter)
    """N(a, y0, c, y)"""
    first: Counter[str] = field(default_factory=Counter)
    """After the first look: `tracked`, `unobs`, `abs`."""
    relation: Counter[str] = field(default_factory=Counter)
    """Of present targets."""
    births: Counter[bool] = field(default_factory=Counter)
    """Steps with new tracks while the target had none: whether one of them is the target."""
    new_tracks: Counter[NewTracks] = field(default_factory=Counter)
    """Looks after the first, by what they gave."""

    def __add__(self, other: "Counts") -> "Counts":
        return Counts(
            self.emission + other.emission,
            self.paired + other.paired,
            self.first + other.first,
            self.relation + other.relation,
            self.births + other.births,
            self.new_tracks + other.new_tracks,
        )


def count(walks: Walks, exhaustive: tuple[str, ...], relation: str | None) -> Counts:
    """What one scene contributes.

    Each capture counts once for N(q, c, y) and the priors, along the exhaustive path. For
    N(a, y0, c, y), every sequence contributes its last action: y0 is what a track had before it;
    likewise for new tracks.

    Args:
        walks: looks by sequence, all sequences of the scene.
        exhaustive: the sequence that sees everything.
        relation: of the target; None when it is absent.
    """
    looks = walks[exhaustive]
    counts = Counts(first=Counter([_category(looks[0].truth)]))
    if relation is not None:
        counts.relation[relation] += 1
    for look in looks:
        counts.emission.update(
            (look.q, _class(look, i, relation), y) for i, y in look.counted.items()
        )
    for before, look in zip(looks, looks[1:], strict=False):
        if before.truth == UNOBS and look.new_tracks:
            counts.births[look.target_track in look.new_tracks] += 1
    for path, steps in walks.items():
        if path:
            counts.paired.update(_pairs(path[-1], steps[-2], steps[-1], relation))
            counts.new_tracks.update(new_tracks(steps[-2], steps[-1]))
    return counts


def _category(truth: str) -> str:
    return truth if truth in (UNOBS, ABS) else "tracked"


def _class(look: Look, track: int, relation: str | None) -> str:
    """The class that the truth implies for a track. Source: eq:truth-class-map."""
    if relation is None or track != look.target_track:
        return DISTRACTOR
    return f"target_{relation}"


def _pairs(
    action: str, before: Look, after: Look, relation: str | None
) -> Iterable[tuple[str, str, str, str]]:
    y0 = {track.id: track.y0 for track in before.reply.tracks}
    for track, y in after.counted.items():
        earlier = y0.get(track)
        if earlier is not None:
            yield action, earlier, _class(after, track, relation), y


def emission_table(counts: Counts) -> dict[str, dict[str, tuple[int, ...]]]:
    """N(q, c, y) as ``[q][class]``: seven counts in the order of the observations."""
    conditions = dict.fromkeys(q for q, _, _ in sorted(counts.emission))
    return {
        q: {
            name: row
            for name in CLASSES
            if any(row := tuple(counts.emission[q, name, y] for y in OBSERVATIONS))
        }
        for q in conditions
    }


def paired_table(counts: Counts) -> dict[str, dict[str, dict[str, tuple[int, ...]]]]:
    """N(a, y0, c, y) as ``[action][y0][class]``; combinations that were never seen are left out."""
    table: dict[str, dict[str, dict[str, tuple[int, ...]]]] = {}
    for action, y0, name, _ in sorted(counts.paired, key=_order):
        row = tuple(counts.paired[action, y0, name, y] for y in OBSERVATIONS)
        table.setdefault(action, {}).setdefault(y0, {})[name] = row
    return table


def _order(key: tuple[str, str, str, str]) -> tuple[str, int, int, int]:
    action, y0, name, y = key
    return action, OBSERVATIONS.index(y0), CLASSES.index(name), OBSERVATIONS.index(y)


def smoothed(hits: int, trials: int, outcomes: int = 2) -> float:
    """Add-one smoothing: the share that is expected next."""
    return float(Fraction(hits + 1, trials + outcomes))


def priors(counts: Counts) -> dict[str, float]:
    """The masses of the first belief, the relation weight and the birth coefficient.

    Without any track, what would be tracked is not yet seen. Source: eq:initial-belief,
    eq:track-birth.
    """
    scenes = counts.first.total()
    absent, unobserved = (smoothed(counts.first[z], scenes, 3) for z in (ABS, UNOBS))
    return {
        "inside": smoothed(counts.relation["inside"], counts.relation.total()),
        "abs": absent,
        "unobs": unobserved,
        "beta_birth": smoothed(counts.births[True], counts.births.total()),
    }
