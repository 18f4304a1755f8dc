"""The analysis plan as code: groups of tests, margins and seeds. `docs/analysis-plan.md` says why.

The plan's file is hashed. Results on the evaluation split carry that hash, and no report of results
with another one is called headline.
"""

from dataclasses import dataclass
from typing import Final, Literal

SHA256: Final = "70d7e89c7288af3bd5bad54c844de977d1ee564d47901009730276f402fb8939"
"""Of `docs/analysis-plan.md`."""

DRAWS: Final = 10_000
SEED: Final = 0
"""Of every resampling and permutation, each anew."""
MARGIN: Final = 0.02
"""A success rate lower by less than this is not worse."""
FAMILY_MARGIN: Final = 0.03
LEVEL: Final = 0.05
LARGEST_PSI: Final = 0.10
"""Of a primary pair on development, above which 600 scenes are too few, where it is close."""
CLOSE: Final = 0.05
"""Difference in success rates."""
PER_FAMILY: Final = {"paper-size": 5, "headline": 120}
STRONG: Final = (
    "roboexp-strong",
    "dovsg-strong",
    "introplan-strong",
    "actpermoma-strong",
    "tampura",
    "pouct-strong",
)
LITE: Final = ("roboexp-lite", "dovsg-lite", "introplan-lite", "actpermoma-lite", "pouct-lite")
ABLATIONS: Final = ("a1", "a2", "a3", "a4", "a5", "a6", "a7", "a8")
LOOKERS: Final = ("exhaustive-look", "cheapest-first")

Test = Literal["success", "not worse and cheaper"]
Key = tuple[str, str]
"""Name of a policy, and the profile whose belief and failure rules it plays with."""
OURS: Final[Key] = ("ours", "extended")
PAPER_METHOD: Final[Key] = ("paper-method", "paper")


@dataclass(frozen=True)
class Group:
    """Comparisons that are corrected together."""

    name: str
    test: Test
    first: Key
    against: tuple[Key, ...]


def _with(profile: str, names: tuple[str, ...]) -> tuple[Key, ...]:
    return tuple((name, profile) for name in names)


GROUPS: Final = (
    Group("primary", "success", OURS, (PAPER_METHOD, *_with("paper", STRONG))),
    Group("same belief", "not worse and cheaper", OURS, _with("extended", STRONG)),
    Group("secondary", "success", OURS, _with("extended", ABLATIONS)),
    Group("secondary, paper's method", "success", PAPER_METHOD, _with("paper", ABLATIONS)),
    Group("tertiary", "not worse and cheaper", OURS, _with("extended", LOOKERS)),
)
