"""`surefetch filter CASES.json`: golden-format cases through the functions the robot runs."""

import argparse
import math
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec

from surefetch.belief import filter as belief_filter
from surefetch.belief.association import Place, associate
from surefetch.belief.evidence import CategoryEvidence, Seen
from surefetch.belief.filter import Memory, Model
from surefetch.common.cases import (
    Case,
    Emissions,
    QHat,
    as_q_hat,
    print_answers,
    read_cases,
    solve_cases,
)
from surefetch.common.conformal import conformal_set, episode_score, quantile, rank
from surefetch.common.emission import Emission
from surefetch.common.hypotheses import IDENTITY_LABELS, MEMBERSHIP_LABELS
from surefetch.common.joint_belief import JointBelief
from surefetch.common.messages import Xyz
from surefetch.common.observations import cyclic_scores, first_of_largest, observation
from surefetch.common.parameters import PRINTED

Letter = Annotated[int, msgspec.Meta(ge=0, le=2)]
Three = tuple[float, float, float]
ThreeLetters = tuple[Letter, Letter, Letter]
Identity = Literal["supported", "contradicted", "unobservable"]
Membership = Literal["inside", "outside", "unknown"]
Label = Literal["MI", "MO", "MU", "mismatch", "UI", "UO", "UU"]


class Value(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A part of a case; unknown fields are errors."""


class Question(Value, frozen=True):
    """One question, answered by letters under three orders."""

    letters: tuple[Three, Three, Three]
    sigma: tuple[ThreeLetters, ThreeLetters, ThreeLetters]

    def label(self, labels: Sequence[str]) -> str:
        return first_of_largest(labels, cyclic_scores(self.letters, self.sigma))


class Logits(Value, frozen=True):
    """The four questions."""

    color: Question
    shape: Question
    marking: Question
    membership: Question

    def observation(self) -> str:
        return observation(
            self.color.label(IDENTITY_LABELS),
            self.shape.label(IDENTITY_LABELS),
            self.marking.label(IDENTITY_LABELS),
            self.membership.label(MEMBERSHIP_LABELS),
        )


class Labels(Value, frozen=True):
    """The four answers."""

    color: Identity
    shape: Identity
    marking: Identity
    membership: Membership

    def observation(self) -> str:
        return observation(self.color, self.shape, self.marking, self.membership)


class CaseDetection(Value, frozen=True):
    """A detection after association, with an observation, answers, logits or nothing."""

    id: str
    track: int
    y: Label | None = None
    answers: Labels | None = None
    logits: Logits | None = None

    def observation(self) -> str | None:
        """Its observation, from whichever of the three it carries."""
        carried = self.answers or self.logits
        return self.y if carried is None else carried.observation()


class CaseStep(Value, frozen=True):
    """One step of an episode."""

    q: str
    tracks: tuple[int, ...]
    detections: tuple[CaseDetection, ...]


class Start(Value, frozen=True):
    """The belief before the first step, and how often each track was observed."""

    belief: dict[str, float]
    counts: dict[str, int]

    def memory(self) -> Memory:
        counts = {int(track): n for track, n in self.counts.items()}
        return Memory(JointBelief.read(self.belief), counts)


class FilterOptions(Value, frozen=True):
    """Switches; a missing one is false."""

    pooled_views: bool = False
    factorized: bool = False


class FilterCase(Case, frozen=True):
    """An episode to filter."""

    emissions: Emissions
    q_hat: QHat
    start: Start | None
    steps: tuple[CaseStep, ...]
    options: FilterOptions = FilterOptions()

    def solve(self) -> dict[str, Any]:
        """The belief and the conformal set after each step."""
        emission = Emission(self.emissions, pooled_views=self.options.pooled_views)
        model = Model(CategoryEvidence(emission), PRINTED, factorized=self.options.factorized)
        memory = Memory() if self.start is None else self.start.memory()
        answers = []
        for case_step in self.steps:
            labels = [d.observation() for d in case_step.detections]
            seen = [
                Seen(d.id, d.track, y) for d, y in zip(case_step.detections, labels, strict=True)
            ]
            done = belief_filter.step(memory, case_step.tracks, seen, case_step.q, model)
            memory = done.memory
            answers.append(_step_answer(done, labels, as_q_hat(self.q_hat)))
        return {"steps": answers}


class ConformalCase(Case, frozen=True):
    """Scores, or the beliefs that make them, to find the threshold of."""

    alpha: str
    scores: tuple[float, ...] | None = None
    truth_beliefs: tuple[tuple[float, ...], ...] | None = None

    def solve(self) -> dict[str, Any]:
        """The scores, their rank and their quantile."""
        scores, alpha = self._scores(), self._alpha()
        q_hat = quantile(scores, alpha)
        return {
            "scores": scores,
            "k": rank(len(scores), alpha),
            "q_hat": "inf" if math.isinf(q_hat) else q_hat,
        }

    def _scores(self) -> list[float]:
        if self.scores is not None:
            return list(self.scores)
        if self.truth_beliefs is None or not all(self.truth_beliefs):
            raise ValueError("needs `scores`, or `truth_beliefs` with a step in every episode")
        return [episode_score(beliefs) for beliefs in self.truth_beliefs]

    def _alpha(self) -> Fraction:
        try:
            alpha = Fraction(self.alpha)
        except (ValueError, ZeroDivisionError):
            raise ValueError(f'alpha "{self.alpha}" is no decimal and no fraction') from None
        if not 0 < alpha < 1:
            raise ValueError(f"alpha {self.alpha} is not between 0 and 1")
        return alpha


class CasePlace(Value, frozen=True):
    """A detection to associate."""

    center: Xyz
    hist: tuple[float, ...] | None

    def place(self) -> Place:
        return Place(self.center, self.hist)


class CaseTrack(CasePlace, frozen=True):
    """A track to associate with."""

    id: int


class AssociationCase(Case, frozen=True):
    """Detections and tracks to match."""

    tracks: tuple[CaseTrack, ...]
    detections: tuple[CasePlace, ...]

    def solve(self) -> dict[str, Any]:
        """Pair costs, matches, new tracks and the total."""
        found = associate([d.place() for d in self.detections], [t.place() for t in self.tracks])
        return {
            "cost": [[None if math.isinf(c) else float(c) for c in row] for row in found.cost],
            "matches": [
                [d, self.tracks[t].id] for d, t in enumerate(found.track_of) if t is not None
            ],
            "new": [d for d, t in enumerate(found.track_of) if t is None],
            "total": found.total,
        }


KINDS: Final[dict[str, type[Case]]] = {
    "filter": FilterCase,
    "conformal": ConformalCase,
    "association": AssociationCase,
}

HELP: Final = """\
example of CASES.json, with one case:
  [{"kind": "conformal", "name": "twenty", "alpha": "0.1", "scores": [0.5, 0.25]}]

The kinds filter, conformal and association; every field is described in
tests/golden/cases/README.md. Prints a JSON list with one object for each case.
"""


def main(argv: list[str]) -> int:
    """Solve every case of a file. Raises BadInput that names the case and the field."""
    parser = argparse.ArgumentParser(
        prog="surefetch filter",
        description="Filter, conformal and association cases in, results out.",
        epilog=HELP,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("cases", type=Path, metavar="CASES.json")
    path = parser.parse_args(argv).cases
    print_answers(solve_cases(read_cases(path, KINDS, command="surefetch filter")))
    return 0


def _step_answer(
    done: belief_filter.Step, labels: list[str | None], q_hat: float
) -> dict[str, Any]:
    belief = done.belief.named()
    return {
        "prior": done.prior.named(),
        "labels": labels,
        "counted": list(done.counted),
        "belief": belief,
        "gamma": list(conformal_set(belief, q_hat)),
    }
