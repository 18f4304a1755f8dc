"""Which seeds may be used for what. Ranges are half open."""

from collections.abc import Iterable
from typing import Final

from surefetch.common.errors import BadInput

SPLITS: Final[dict[str, range]] = {
    "development": range(100_000, 200_000),
    "calibration": range(200_000, 300_000),
    "evaluation": range(300_000, 400_000),
    "perception": range(400_000, 450_000),
    "failure-injection": range(450_000, 500_000),
    "execution": range(500_000, 550_000),
    "stress": range(600_000, 700_000),
}
"""Everything else is an ordinary scene, from which nothing is fitted."""

FAMILIES: Final = ("visible", "partial", "covered", "ambiguous", "absent")


def seeds_of(split: str | None, episodes: int | None, seeds: str | None) -> range:
    """The seeds named by `--split S --episodes N` or by `--seeds A:B`.

    Raises:
        BadInput: neither or both are given, or one is malformed.
    """
    if (split is None) == (seeds is None):
        raise BadInput("name the scenes by --split S --episodes N, or by --seeds A:B.")
    if seeds is not None:
        return _range(seeds)
    if split not in SPLITS:
        raise BadInput(f'there is no split "{split}".\n  Splits: {", ".join(SPLITS)}')
    if episodes is None or not 0 < episodes <= len(SPLITS[split]):
        raise BadInput(f"--episodes must be between 1 and {len(SPLITS[split])}, per family.")
    return SPLITS[split][:episodes]


def _range(text: str) -> range:
    try:
        start, stop = (int(part) for part in text.split(":"))
    except ValueError:
        raise BadInput(f'--seeds takes A:B, two whole numbers; found "{text}".') from None
    if not 0 <= start < stop <= 2**63:
        raise BadInput(f"--seeds {text}: the range must not be empty and lie in 0 … 2^63.")
    return range(start, stop)


def families_of(text: str | None) -> tuple[str, ...]:
    """The families named by `--families`, all by default. Raises BadInput for an unknown one."""
    if text is None:
        return FAMILIES
    names = tuple(name.strip() for name in text.split(","))
    for name in names:
        if name not in FAMILIES:
            raise BadInput(f'there is no family "{name}".\n  Families: {", ".join(FAMILIES)}')
    return names


def require(split: str, seeds: Iterable[int], what: str) -> None:
    """Refuse seeds of another split.

    Raises:
        BadInput: names the first seed that does not belong.
    """
    allowed = SPLITS[split]
    for seed in seeds:
        if seed not in allowed:
            raise BadInput(
                f"{what} uses {split} scenes only (seeds {allowed.start}–{allowed.stop - 1}); "
                f"seed {seed} is not one.\n"
                f"  Record some: surefetch study record --split {split} --episodes N --out DIR"
            )
