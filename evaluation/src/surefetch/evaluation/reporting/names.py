"""Policies as the report names them. Pure."""

from typing import Final

from surefetch.evaluation.reporting.paper_numbers import ABLATIONS
from surefetch.evaluation.reporting.plan import OURS, PAPER_METHOD, Key

BELIEFS: Final = {"paper": "paper-method's belief and rules", "extended": "the belief of ours"}
NAMES: Final = {
    "ours": "ours",
    "paper-method": "paper-method",
    "roboexp-strong": "RoboEXP strong (no LLM)",
    "roboexp-lite": "RoboEXP lite (no LLM)",
    "dovsg-strong": "DovSG strong (no LLM)",
    "dovsg-lite": "DovSG lite (no LLM)",
    "introplan-strong": "IntroPlan strong (no LLM)",
    "introplan-lite": "IntroPlan lite (no LLM)",
    "knowno": "KnowNo (no LLM)",
    "actpermoma-strong": "ActPerMoMa strong",
    "actpermoma-lite": "ActPerMoMa lite",
    "tampura": "TAMPURA-like",
    "tampura-undiscounted": "TAMPURA-like, undiscounted",
    "pouct-strong": "POUCT strong",
    "pouct-lite": "POUCT lite",
    "pouct-strong-gated": "POUCT strong, gated",
    "pouct-lite-gated": "POUCT lite, gated",
    "exhaustive-look": "exhaustive look",
    "exhaustive-look-if-inside": "exhaustive look, opening unless asked for outside",
    "cheapest-first": "gated cheapest-first",
    "best-fixed": "best fixed sequence",
    "greedy": "greedy MAP",
    "greedy-threshold": "greedy MAP with threshold",
    "always-defer": "always defer",
    "random": "random",
    "truth-oracle": "truth oracle (upper bound)",
    "hindsight": "hindsight ceiling (upper bound)",
    **{code: row.name for code, row in ABLATIONS.items()},
}


def of(key: Key) -> str:
    """A policy with whose belief it plays, where that is not its own."""
    name, profile = key
    told = NAMES.get(name, name)
    return told if key in (OURS, PAPER_METHOD) else f"{told}, {BELIEFS.get(profile, profile)}"


def short(key: Key) -> str:
    """For legends."""
    name, profile = key
    full = name.upper() if name in ABLATIONS else NAMES.get(name, name)
    told = full.replace(" (no LLM)", "").replace(" strong", "").replace(" (upper bound)", "")
    return told if key in (OURS, PAPER_METHOD) else f"{told} @{profile}"
