"""Every opening of recordings of the evaluation split, as a line in a file beside them.

`DIR/openings.jsonl` only grows. Each line holds the hash of the one before it, so that a line that
was changed or taken out shows.
"""

import fcntl
import hashlib
from collections.abc import Iterable, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import msgspec

from surefetch.common.errors import BadInput
from surefetch.common.version import VERSION
from surefetch.evaluation.recordings import recording_store
from surefetch.evaluation.recordings.splits import SPLITS
from surefetch.evaluation.reporting import plan
from surefetch.evaluation.reporting.commit import commit

NAME: Final = "openings.jsonl"
FIRST: Final = "0" * 64
"""What the first line holds in place of an earlier line's hash."""


class Opening(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """One time that policies were played on recordings of the evaluation split."""

    at: str
    """UTC, ISO 8601."""
    surefetch: str
    commit: str
    plan: str
    """Hash of the analysis plan."""
    parameters: dict[str, str]
    """Hash of the fitted numbers, by profile."""
    policies: dict[str, str]
    """Hash of the code that decides how it is played, by policy."""
    seeds: tuple[int, int]
    """First and last, of all families."""
    n_scenes: int
    outcomes: dict[str, Any]
    injected: Any
    command: str
    previous: str
    """Hash of the line before."""


def concerns(scenes: Iterable[tuple[str, int]]) -> bool:
    """Whether some of these scenes are of the evaluation split."""
    return any(seed in SPLITS["evaluation"] for _, seed in scenes)


def sealed(recordings: Path) -> dict[str, str]:
    """What results on these recordings say of the plan: nothing, unless it is the evaluation."""
    return {"plan": plan.SHA256} if concerns(recording_store.scenes(recordings)) else {}


def note(
    recordings: Path, made_with: Mapping[str, Any], policies: Mapping[str, str], command: str
) -> None:
    """Add a line, before recordings of the evaluation split are opened; of others none.

    Args:
        recordings: their folder.
        made_with: as in the manifest of the results.
        policies: those that are going to be played, with the hash of their code.
        command: that opens them.

    Raises:
        BadInput: the ledger was tampered with.
    """
    scenes = recording_store.scenes(recordings)
    if not concerns(scenes):
        return
    seeds = [seed for _, seed in scenes]
    path = recordings / NAME
    with path.open("a+b") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        file.seek(0)
        lines = file.read().splitlines()
        _check(lines, path)
        opening = Opening(
            at=datetime.now(UTC).isoformat(timespec="seconds"),
            surefetch=VERSION,
            commit=commit(),
            plan=plan.SHA256,
            parameters=dict(made_with["parameters"]),
            policies=dict(policies),
            seeds=(min(seeds), max(seeds)),
            n_scenes=len(scenes),
            outcomes=dict(made_with["outcomes"]),
            injected=made_with["injected"],
            command=command,
            previous=_hash(lines[-1]) if lines else FIRST,
        )
        file.write(msgspec.json.encode(opening) + b"\n")


def read(recordings: Path) -> list[Opening]:
    """All openings so far, in order.

    Raises:
        BadInput: a line cannot be read, or does not follow the one before it.
    """
    path = recordings / NAME
    lines = path.read_bytes().splitlines() if path.exists() else []
    return _check(lines, path)


def _check(lines: Sequence[bytes], path: Path) -> list[Opening]:
    previous, openings = FIRST, []
    for number, line in enumerate(lines, start=1):
        try:
            opening = msgspec.json.decode(line, type=Opening)
        except msgspec.DecodeError as error:
            raise BadInput(f"{path}, line {number}: {error}") from None
        if opening.previous != previous:
            raise BadInput(
                f"{path}, line {number} does not follow the line before it: the ledger was "
                "changed after it was written.\n  Bring back the file as it was."
            )
        previous = _hash(line)
        openings.append(opening)
    return openings


def _hash(line: bytes) -> str:
    return hashlib.sha256(line).hexdigest()
