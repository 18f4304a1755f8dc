"""What came of every episode that a policy played: one line of JSON each, one file per policy.

A folder of results holds ``POLICY.jsonl`` for each policy and ``manifest.json``, which says what
they were made with. The scorer writes them and the report reads them; no policy ever does.
"""

import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final, Literal

import msgspec

from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import AskedRelation, Relation
from surefetch.evaluation.recordings.recording import Cover
from surefetch.evaluation.running.metrics import Scored, Verdict

SUFFIX: Final = ".jsonl"
MOST_HYPOTHESES: Final = 8
"""Tracked hypotheses that a step keeps, the heaviest first."""


class ResultValue(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A frozen part of a line; unknown and missing fields are refused when reading."""


class StepResult(ResultValue, frozen=True):
    """One turn: what was seen and believed, and what was chosen on it."""

    view: str
    cover: Cover
    """The true one."""
    q: str
    """Viewing condition, as verified."""
    counted: bool
    """False: this (view, cover state) was seen before; its answers are no new evidence."""
    delivered: str
    """Hash of what the belief was given: equal looks at one scene, equal hash for all policies."""
    observations: tuple[str, ...]
    """Those that counted, ``TRACK CATEGORY`` each."""
    belief: dict[str, float]
    """The heaviest tracked hypotheses, heaviest first, at most `MOST_HYPOTHESES`."""
    unobs: float
    abs: float
    gamma: tuple[str, ...]
    z_true: str
    """z*: the target's track and relation, `unobs` while it has no track, or `abs`."""
    p_true: float
    """b(z*)."""
    action: str | None
    """What was chosen, as in `EpisodeResult.actions`; None: nothing, or it was over before."""
    because: str
    """The policy's own words, empty for those that have none."""
    planning_s: float
    """By the clock."""

    @property
    def z_in_gamma(self) -> bool:
        """Whether the conformal set holds the truth."""
        return self.z_true in self.gamma


class GraspResult(ResultValue, frozen=True):
    """One attempt to grasp."""

    track: int
    relation: Relation
    p: float
    """Belief in it."""
    body: str | None
    """What lay under the track's latest detection; None: no body."""
    on_target: bool
    held: bool
    injected: bool
    """Reported as failed by injection; the arm did not move."""


class EpisodeResult(ResultValue, frozen=True):
    """One episode of one policy."""

    policy: str
    """As it was asked for: `NAME`, or `NAME@PROFILE`; the name of the file."""
    profile: str
    """Whose belief and failure rules."""
    variant: str
    """Of the belief."""
    family: str
    seed: int
    stratum: str
    covered: bool
    """Whether the scene begins with a cover on the container."""
    asked: AskedRelation
    target_present: bool
    verdict: Verdict
    outcome: str
    """As the episode's own rules say: grasped, deferred, failed, stalled or aborted."""
    reason: str
    why: str
    """How it ended, in words; of an episode that left the recording, where it left it."""
    actions: tuple[str, ...]
    """In order: `right`, `remove_cover`, `grasp 3 inside`, `defer` …; what was tried in vain ends
    with ` (failed)`, what was reported so by injection with ` (failed, injected)`."""
    n_actions: int
    """Information actions and grasps, failed ones included."""
    cost: float
    """Sum of the planner's constants of the actions."""
    realized_cost: float
    """The planner's own objective, with what really happened in it."""
    duration_s: float
    """Modelled: recorded motions and perception; planning is not in it."""
    commit_p: float
    """Belief in the grasp that was tried last, or else in the best that was open at the end; 0
    where none was. Source: EVALUATION 5.6, risk–coverage."""
    grasps: tuple[GraspResult, ...]
    q_hat: float | Literal["inf"]
    steps: tuple[StepResult, ...]
    """Empty for the oracle, which believes nothing."""
    finished_live: bool = False
    """It left the recording, and went on in the simulator from there."""

    @property
    def scored(self) -> Scored:
        """As the tables count it."""
        return Scored(self.family, self.seed, self.verdict, self.n_actions, self.cost)

    @property
    def z_in_gamma(self) -> tuple[bool, ...]:
        """For every visited step, whether the conformal set held the truth."""
        return tuple(step.z_in_gamma for step in self.steps)

    @property
    def planning_s(self) -> tuple[float, ...]:
        """Of every decision."""
        return tuple(step.planning_s for step in self.steps)

    @property
    def log_p_true(self) -> float | None:
        """Log b(z*) at the last step; None for the oracle. −inf where the belief ruled it out."""
        if not self.steps:
            return None
        p = self.steps[-1].p_true
        return math.log(p) if p > 0.0 else -math.inf

    @property
    def threshold(self) -> float:
        """q̂ as a number."""
        return math.inf if self.q_hat == "inf" else self.q_hat


def path_of(folder: Path, policy: str) -> Path:
    """Where a policy's episodes are."""
    return folder / f"{policy}{SUFFIX}"


def write(folder: Path, policy: str, episodes: Iterable[EpisodeResult]) -> None:
    """Write all episodes of a policy; all or nothing."""
    path = path_of(folder, policy)
    partial = path.with_suffix(".partial")
    with partial.open("wb") as file:
        for episode in episodes:
            file.write(msgspec.json.encode(episode) + b"\n")
    partial.replace(path)


def read(folder: Path, policy: str) -> list[EpisodeResult]:
    """All episodes of a policy, in the order of the scenes. Raises BadInput naming the line."""
    path = path_of(folder, policy)
    try:
        with path.open("rb") as file:
            return list(_decoded(file, path))
    except OSError as error:
        raise BadInput(
            f"{path} cannot be read: {error.strerror}.\n"
            f"  Make it: surefetch study evaluate --recordings DIR --policies {policy} "
            f"--out {folder}"
        ) from None


def policies(folder: Path) -> list[str]:
    """Policies whose episodes are in the folder, by name."""
    return sorted(path.name.removesuffix(SUFFIX) for path in folder.glob(f"*{SUFFIX}"))


def _decoded(lines: Iterable[bytes], path: Path) -> Iterator[EpisodeResult]:
    decoder = msgspec.json.Decoder(EpisodeResult)
    for number, line in enumerate(lines, start=1):
        try:
            yield decoder.decode(line)
        except msgspec.DecodeError as error:
            raise BadInput(
                f"{path}, line {number}: {error}\n  Take the file away and evaluate again."
            ) from None
