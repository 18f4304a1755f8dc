"""Where fitted numbers come from, as their file says it. Pure."""

from collections.abc import Iterable, Sequence

from surefetch.common.cell import Cell
from surefetch.common.errors import BadInput
from surefetch.common.parameters import Provenance
from surefetch.evaluation.recordings.recording import Recording


def provenance(
    cell: Cell, backend: str, split: str, scenes: Iterable[tuple[str, int]], note: str
) -> Provenance:
    """Of numbers from these scenes, families and seeds."""
    chosen = list(scenes)
    return Provenance(
        cell=cell.name,
        backend=backend,
        split=split,
        n_episodes=len(chosen),
        seeds=_ranges(sorted({seed for _, seed in chosen})),
        note=note,
    )


def _ranges(seeds: Sequence[int]) -> str:
    """Sorted seeds as half-open ranges, ``"100000:100040 100050:100060"``."""
    runs: list[list[int]] = []
    for seed in seeds:
        if runs and runs[-1][1] == seed:
            runs[-1][1] = seed + 1
        else:
            runs.append([seed, seed + 1])
    return " ".join(f"{start}:{stop}" for start, stop in runs)


def one_backend(earlier: str, recording: Recording) -> str:
    """The perception of all recordings so far, "" before the first, and of one more.

    Raises:
        BadInput: they differ.
    """
    if earlier not in ("", recording.backend):
        raise BadInput(
            f"the recordings come from two perceptions, {earlier} and {recording.backend}; "
            "parameters belong to one. Keep them in folders of their own."
        )
    return recording.backend
