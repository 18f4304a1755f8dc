"""Sequences of information actions through recorded states, and the looks along them. Pure."""

from collections.abc import Callable, Iterable

from surefetch.belief.episode import EpisodeBelief
from surefetch.common.cell import Cell
from surefetch.common.messages import BeliefReply, Update
from surefetch.evaluation.recordings.recording import (
    Path,
    Recording,
    RecordingTruth,
    paths,
    state_after,
)
from surefetch.evaluation.recordings.walk import Look, look_of, update_after
from surefetch.planner.profiles import PROFILES

Believed = Callable[[EpisodeBelief, Update], tuple[EpisodeBelief, BeliefReply]]
"""One step of the belief, from one frozen belief to the next."""


def allowed_sequences(recording: Recording, profile: str, cell: Cell) -> list[Path]:
    """All that a profile admits on a scene, the longer after their beginnings."""
    views_while_covered = PROFILES[profile].views_while_covered
    return paths(recording.covered, cell, views_while_covered=views_while_covered)


def beginnings(path: Path) -> list[Path]:
    """The sequence, after all that it begins with."""
    return [path[:n] for n in range(len(path) + 1)]


def longest(found: Iterable[Path]) -> Path:
    """The sequence that sees the most states, the first of equals."""
    return max(found, key=len)


def looks_along(
    recording: Recording,
    truth: RecordingTruth,
    found: Iterable[Path],
    cell: Cell,
    begin: EpisodeBelief,
    step: Believed,
    *,
    profile: str,
    remembers: bool = True,
) -> dict[Path, list[Look]]:
    """The looks of every sequence; what sequences begin with alike is believed once.

    Args:
        recording: the scene.
        truth: the scorer's file of it.
        found: sequences, each after its beginnings.
        cell: of the recording.
        begin: the belief before the first look.
        step: what believes a look.
        profile: named in the updates.
        remembers: False: a track is gone with the look that showed it.
    """
    beliefs: dict[Path, EpisodeBelief] = {}
    looks: dict[Path, list[Look]] = {}
    for path in found:
        before = looks[path[:-1]] if path else []
        update = update_after(recording, path, cell, profile)
        beliefs[path], reply = step(beliefs[path[:-1]] if path else begin, update)
        bodies = truth.bodies(state_after(path, recording.covered, cell))
        last = before[-1] if before else None
        look = look_of(update, reply, bodies, truth, last, remembers=remembers)
        looks[path] = [*before, look]
    return looks
