"""What looks gave of new tracks, by what became of a target not seen before. Pure."""

from collections import Counter
from collections.abc import Iterator
from typing import Final, Literal

from surefetch.common.hypotheses import UNOBS
from surefetch.common.parameters import BirthCounts, CoverKey
from surefetch.evaluation.recordings.walk import Look

Target = Literal["appeared", "stayed", "known"]
"""Its first track is among the new ones; it still has none; it had one before, or is absent."""
NewTracks = tuple[str, CoverKey, Target, int]
"""Viewing condition, cover state, the target, and the number of new tracks, at most MANY."""
MANY: Final = 2


def new_tracks(before: Look, after: Look) -> Iterator[NewTracks]:
    """What one look gave; nothing where an unseen target was taken for a track that there was."""
    cover: CoverKey = "covered" if after.covered else "open"
    n = min(len(after.new_tracks), MANY)
    if before.truth != UNOBS:
        yield after.q, cover, "known", n
    elif after.target_track in after.new_tracks:
        yield after.q, cover, "appeared", n
    elif after.truth == UNOBS:
        yield after.q, cover, "stayed", n


def birth_table(counted: Counter[NewTracks]) -> dict[str, dict[CoverKey, BirthCounts]]:
    """The counts as a parameter file holds them."""
    table: dict[str, dict[CoverKey, BirthCounts]] = {}
    for q, cover in dict.fromkeys((q, cover) for q, cover, _, _ in sorted(counted)):
        table.setdefault(q, {})[cover] = _birth_counts(counted, q, cover)
    return table


def _birth_counts(counted: Counter[NewTracks], q: str, cover: CoverKey) -> BirthCounts:
    appeared = [counted[q, cover, "appeared", n] for n in range(MANY + 1)]
    stayed = [counted[q, cover, "stayed", n] for n in range(MANY + 1)]
    none, one, many = (s + counted[q, cover, "known", n] for n, s in enumerate(stayed))
    return BirthCounts(
        with_target=(appeared[1], appeared[2]),
        without=(none, one, many),
        still_unseen=sum(stayed),
    )
