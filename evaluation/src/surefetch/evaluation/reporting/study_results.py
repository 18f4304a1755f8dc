"""What a report is made from: the results of a campaign, and what they may be called. Pure."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from surefetch.common.errors import BadInput
from surefetch.evaluation.recordings.splits import FAMILIES, SPLITS
from surefetch.evaluation.replaying.contenders import WITH
from surefetch.evaluation.replaying.manifest import Manifest
from surefetch.evaluation.replaying.results import EpisodeResult
from surefetch.evaluation.reporting import plan
from surefetch.evaluation.reporting.ledger import Opening
from surefetch.evaluation.reporting.plan import Key

Episodes = Sequence[EpisodeResult]
STRONG: str = "-strong"
MOST_EXCLUDED = 0.01


@dataclass(frozen=True, eq=False)
class Study:
    """One folder of results."""

    manifest: Manifest
    played: Mapping[Key, Episodes]
    """By policy and profile; never empty, all on the same scenes."""
    labels: Mapping[Key, str]
    """What each was asked for as."""

    @property
    def scenes(self) -> list[tuple[str, int]]:
        """Families and seeds."""
        return [(e.family, e.seed) for e in next(iter(self.played.values()))]

    @property
    def split(self) -> str | None:
        """The split that all scenes belong to; None: to several, or to none."""
        seeds = {seed for _, seed in self.scenes}
        return next((name for name, of in SPLITS.items() if seeds <= set(of)), None)

    @property
    def per_family(self) -> int:
        """Scenes in the smallest family."""
        return min(sum(family == f for f, _ in self.scenes) for family in FAMILIES)

    def first(self, n: int) -> "Study":
        """The same policies on the first scenes of each family, by seed."""
        chosen = {
            (family, seed)
            for family in FAMILIES
            for seed in sorted(seed for f, seed in self.scenes if f == family)[:n]
        }
        return Study(
            self.manifest,
            {k: [e for e in of if (e.family, e.seed) in chosen] for k, of in self.played.items()},
            self.labels,
        )


def study(manifest: Manifest, results: Mapping[str, Episodes]) -> Study:
    """A folder of results, its policies known by name and profile.

    Raises:
        BadInput: there are none, policies played different scenes, or one is there twice.
    """
    labels: dict[Key, str] = {}
    scenes: list[tuple[str, int]] | None = None
    for label, episodes in results.items():
        here = [(e.family, e.seed) for e in episodes]
        if scenes is None:
            scenes = here
        if here != scenes or not episodes:
            raise BadInput(
                f"the policies in this folder did not all play the same scenes: {label} played "
                f"{len(here)}, others {len(scenes)}.\n  Evaluate again into another folder."
            )
        key = key_of(label, episodes[0].profile)
        if key in labels:
            raise BadInput(
                f"{label} and {labels[key]} are the same policy.\n"
                "  Take the file of one of them out of the folder."
            )
        labels[key] = label
    if not labels:
        raise BadInput("there are no results to report.\n  Make some: surefetch study evaluate")
    return Study(manifest, {key: results[label] for key, label in labels.items()}, labels)


def key_of(label: str, profile: str) -> Key:
    """Name and profile of a policy as it was asked for; `-strong` is what plain names mean."""
    return label.partition(WITH)[0].removesuffix(STRONG), profile


def why_not_headline(one: Study, openings: Sequence[Opening]) -> list[str]:
    """What keeps results from being called headline, in words; empty: nothing does."""
    reasons = []
    if one.split != "evaluation":
        reasons.append(f"the scenes are of {one.split or 'no one split'}, not of evaluation")
    if one.per_family < plan.PER_FAMILY["headline"]:
        reasons.append(
            f"{one.per_family} scenes per family; headline takes {plan.PER_FAMILY['headline']}"
        )
    made: Mapping[str, Any] = one.manifest.made_with
    if made.get("plan") != plan.SHA256:
        told = made.get("plan") or "no plan"
        reasons.append(f"the results follow {told[:12]}, not the plan {plan.SHA256[:12]}")
    reasons += _unlogged(one, openings)
    if others := sum(opening.plan != plan.SHA256 for opening in openings):
        reasons.append(f"the recordings were opened {others} times under another plan")
    if others := sum(_differs(opening.parameters, made) for opening in openings):
        reasons.append(f"the recordings were opened {others} times with other parameters")
    if aborted := sum(e.verdict == "aborted" for of in one.played.values() for e in of):
        reasons.append(f"{aborted} episodes left their recording or were cut short")
    if made.get("injected"):
        reasons.append("failures were injected")
    return reasons


def _differs(parameters: Mapping[str, str], made: Mapping[str, Any]) -> bool:
    """Whether some profile had other numbers then; an opening may tell of one profile alone."""
    known = made.get("parameters", {})
    return any(known.get(profile) != value for profile, value in parameters.items())


def _unlogged(one: Study, openings: Sequence[Opening]) -> list[str]:
    """Policies of which no opening of the recordings tells."""
    known = {(label, code) for opening in openings for label, code in opening.policies.items()}
    missing = [
        label
        for label in one.labels.values()
        if (label, one.manifest.policies.get(label, {}).get("code")) not in known
    ]
    return [f"the ledger has no line for {', '.join(missing)}"] if missing else []
