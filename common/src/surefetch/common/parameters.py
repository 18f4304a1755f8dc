"""Fitted numbers: what they are, where they come from, and whom they serve.

A parameter file belongs to one cell and one perception back-end. The two that ship are in
`parameters/`, one per profile; `surefetch study fit` and `surefetch study calibrate` write them.
"""

import math
import re
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from typing import Annotated, Final, Literal, get_args

import msgspec

from surefetch.common.answer_tables import AnswerTables, Company, Count, ParameterValue, Probability
from surefetch.common.emission import Emission
from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import ASKED, CLASSES, OBSERVATIONS, RELATIONS, AskedRelation
from surefetch.common.messages import Name, Text

FORMAT: Final = 1
PROFILES: Final = ("paper", "extended")
FULL: Final = "full"
"""The calibration of the belief with nothing taken out."""

PAPER_TEMPERING: Final = 0.5
"""The n-th observation of a track counts with exponent n^-γ. Source: eq:runtime-belief-update."""

CountRow = Annotated[
    tuple[Annotated[int, msgspec.Meta(ge=0)], ...],
    msgspec.Meta(min_length=len(OBSERVATIONS), max_length=len(OBSERVATIONS)),
]
CoverKey = Literal["open", "covered"]
CountTable = dict[str, dict[str, CountRow]]
"""N(q, c, y) as ``[q][class]``."""
PairedTable = dict[str, CountTable]
"""N(a, y0, c, y) as ``[action][y0][class]``."""


class Provenance(ParameterValue, frozen=True):
    """Where numbers come from."""

    cell: Name
    backend: Name
    """Perception back-end."""
    split: Name
    """`development`, `calibration`, or `none` for numbers that nobody measured."""
    n_episodes: Annotated[int, msgspec.Meta(ge=0)]
    seeds: str
    """Half-open ranges as ``A:B``, empty for `none`."""
    note: Text


class BeliefPriors(ParameterValue, frozen=True):
    """Chances before any answer."""

    relation: dict[str, Probability]
    """π_R, over the relations."""
    absent: Probability
    """b0(abs)"""
    unobserved: Probability
    """b0(unobs), when there are tracks; without any it has `tracked` too."""
    tracked: Probability
    """b0 of all tracks together."""
    birth: Probability
    """β_birth, the share of unobs that new tracks take."""


class BirthCounts(ParameterValue, frozen=True):
    """How many new tracks a look gave, by whether the target's first is among them."""

    with_target: tuple[Count, Count]
    """One new track, and it is the target's; more, and one of them is."""
    without: tuple[Count, Count, Count]
    """No, one, more new tracks, none of them the target's."""
    still_unseen: Count
    """Of the looks in `without`, those at a target that had no track before."""

    @property
    def p_appears(self) -> float:
        """d: chance that the look gives an unseen target its first track, add-one smoothed."""
        appeared = sum(self.with_target)
        return (appeared + 1.0) / (appeared + self.still_unseen + 2.0)

    def likelihood_ratio(self, n_new: int) -> float:
        """A(n) / C(n): n new tracks if the target is one of them, against if it is not.

        Both are shares of the looks, add-one smoothed, with all n above one as one case. Without a
        new track the target is none.
        """
        if n_new == 0:
            return 0.0
        n = min(n_new, 2)
        among = (self.with_target[n - 1] + 1.0) / (sum(self.with_target) + 2.0)
        return among * (sum(self.without) + 3.0) / (self.without[n] + 1.0)


class Priors(BeliefPriors, frozen=True):
    """Chances before any answer, and of interactions that succeed."""

    p_remove: Probability
    p_grasp: Probability


class Scores(ParameterValue, frozen=True):
    """Nonconformity scores of the calibration episodes, in short."""

    smallest: float
    median: float
    largest: float


class Calibration(ParameterValue, frozen=True):
    """A conformal threshold and what it rests on."""

    q_hat: float | Literal["inf"]
    alpha: str
    """Exact: a decimal or a fraction."""
    scores: Scores | None
    coverage_range: tuple[Probability, Probability]
    """5 % to 95 % range of the true coverage that so many episodes support."""
    provenance: Provenance

    @property
    def threshold(self) -> float:
        """q̂ as a number."""
        return math.inf if self.q_hat == "inf" else self.q_hat


class Parameters(ParameterValue, frozen=True):
    """Everything fitted that belief and planner use, for one profile."""

    profile: Name
    fitted_on: Provenance
    """Of the priors, the emission and the paired counts."""
    priors: Priors
    emissions: CountTable
    paired: PairedTable
    calibrations: dict[str, Calibration]
    """By variant of the belief: `full`, and the ablations that change the belief."""
    asked_prior: dict[AskedRelation, BeliefPriors] | None = None
    """Priors by asked relation, in the place of those for all; null: off."""
    cover_prior: dict[CoverKey, dict[AskedRelation, BeliefPriors]] | None = None
    """Priors by cover state and asked relation, in the place of `asked_prior`; null: off."""
    attribute_evidence: AnswerTables | None = None
    """The four answers as evidence of their own, in the place of `emissions`; null: off."""
    company: Company | None = None
    """How unlike tables with and without a target are; needs `attribute_evidence`; null: off."""
    tempering: Annotated[float, msgspec.Meta(ge=0.0)] = PAPER_TEMPERING
    """γ: the n-th observation of a track counts with exponent n^-γ."""
    births: dict[str, dict[CoverKey, BirthCounts]] | None = None
    """New tracks, and none, as evidence, ``[q][cover state at the look]``, in the place of the
    `birth` of the priors; null: off. May have gaps."""
    commit_at_least: Probability = 0.0
    """Least belief in a hypothesis at which its object may be grasped."""
    format: Literal[1] = FORMAT

    def emission(self, *, pooled_views: bool = False) -> Emission:
        """The observation model."""
        return Emission(self.emissions, pooled_views=pooled_views)

    def belief_priors(self, asked: AskedRelation, *, covered: bool = False) -> BeliefPriors:
        """What is believed before any answer when this relation is asked for."""
        if self.cover_prior is not None:
            return self.cover_prior[_cover_key(covered)][asked]
        return self.priors if self.asked_prior is None else self.asked_prior[asked]

    def birth_counts(self, q: str, *, covered: bool = False) -> BirthCounts | None:
        """What was counted of looks under a viewing condition and cover state.

        Returns:
            None where evidence from not seeing is off, or was never fitted for this look.
        """
        return (self.births or {}).get(q, {}).get(_cover_key(covered))

    def p_appears(self, q: str, *, covered: bool = False) -> float:
        """Chance that a look gives the target its first track, while it has none.

        Args:
            q: the viewing condition of the look: of an information action, its `q`.
            covered: whether the container is covered when the look is taken; after a removal
                it is not.

        Returns:
            0.0 where evidence from not seeing is off, or was never fitted for this look.
        """
        counts = self.birth_counts(q, covered=covered)
        return 0.0 if counts is None else counts.p_appears

    def calibration(self, variant: str = FULL) -> Calibration:
        """The calibration of one variant of the belief. Raises BadInput if it was not made."""
        if variant in self.calibrations:
            return self.calibrations[variant]
        raise BadInput(
            f'profile "{self.profile}" has no calibration for the belief "{variant}".\n'
            f"  Calibrated: {', '.join(sorted(self.calibrations))}\n"
            f"  Make it: surefetch study calibrate"
        )

    def q_hat(self, variant: str = FULL) -> float:
        """The conformal threshold of one variant of the belief."""
        return self.calibration(variant).threshold


PRINTED: Final = Priors(
    relation={"inside": 9 / 22, "outside": 13 / 22},
    absent=5 / 27,
    unobserved=1 / 3,
    tracked=13 / 27,
    birth=9 / 14,
    p_remove=4 / 5,
    p_grasp=6 / 7,
)
"""The paper's constants. Source: eq:initial-belief, eq:track-birth, text above
eq:terminal-costs."""


def shipped_parameters(profile: str) -> Parameters:
    """The parameters that ship for a profile. Raises BadInput that lists the profiles."""
    if profile not in PROFILES:
        raise BadInput(f'there is no profile "{profile}".\n  Profiles: {", ".join(PROFILES)}')
    path = f"parameters/{profile}.json"
    return parse_parameters(resources.files("surefetch.common").joinpath(path).read_bytes(), path)


def profile_parameters(profile: str, folder: Path | None) -> Parameters:
    """Parameters of a profile: from ``FOLDER/PROFILE.json``, or without a folder the shipped ones.

    Raises:
        BadInput: there is no such profile or file, or it is damaged.
    """
    shipped = shipped_parameters(profile)
    return shipped if folder is None else read_parameters(folder / f"{profile}.json")


def read_parameters(path: Path) -> Parameters:
    """Read and check a parameter file. Raises BadInput naming the file and the key."""
    try:
        return parse_parameters(path.read_bytes(), str(path))
    except OSError as error:
        raise BadInput(f"parameter file {path} cannot be read: {error.strerror}") from None


def parse_parameters(content: bytes, origin: str) -> Parameters:
    """Checked parameters from JSON; `origin` names them in errors."""
    try:
        parameters = msgspec.json.decode(content, type=Parameters)
        _check_words(parameters)
    except (msgspec.DecodeError, ValueError) as error:
        raise BadInput(f"parameter file {origin}: {error}") from None
    return parameters


def write_parameters(path: Path, parameters: Parameters) -> None:
    """Write a parameter file for people to read and version control to compare."""
    text = msgspec.json.format(msgspec.json.encode(parameters), indent=2).decode()
    path.write_text(_rows_on_one_line(text) + "\n", encoding="utf-8")


def check_origin(parameters: Parameters, *, cell: str, backend: str) -> None:
    """Refuse parameters of another cell or perception back-end.

    Raises:
        BadInput: names both sides and the commands that fit new parameters.
    """
    calibrated = [("calibrated", c.provenance) for c in parameters.calibrations.values()]
    for what, origin in [("fitted", parameters.fitted_on), *calibrated]:
        if (origin.cell, origin.backend) != (cell, backend):
            raise BadInput(
                f'the parameters of profile "{parameters.profile}" were {what} on cell '
                f'"{origin.cell}" with perception "{origin.backend}";\n'
                f'  this is cell "{cell}" with perception "{backend}". Fit new ones:\n'
                f"  surefetch study record --split development --episodes 60 --out DEV\n"
                f"  surefetch study record --split calibration --episodes 44 --out CAL\n"
                f"  surefetch study fit DEV --out FITTED\n"
                f"  surefetch study calibrate CAL --parameters FITTED\n"
                f"  Nothing was moved."
            )


def _check_words(parameters: Parameters) -> None:
    """Refuse unknown classes, observations and relations, which decoding lets through."""
    paired = [table for by_y0 in parameters.paired.values() for table in by_y0.values()]
    _known(
        "class", CLASSES, {c for table in (*parameters.emissions.values(), *paired) for c in table}
    )
    _known("observation", OBSERVATIONS, {y for by_y0 in parameters.paired.values() for y in by_y0})
    for priors in (parameters.priors, *_conditioned(parameters)):
        if set(priors.relation) != set(RELATIONS):
            raise ValueError(f"the relation of every prior must have {', '.join(RELATIONS)}")
    if parameters.company is not None and parameters.attribute_evidence is None:
        raise ValueError("company needs attribute_evidence")
    if FULL not in parameters.calibrations:
        raise ValueError(f'calibrations must have "{FULL}"')


def _conditioned(parameters: Parameters) -> Iterator[BeliefPriors]:
    """The priors by asked relation and cover state. Raises ValueError where some are missing."""
    tables = {} if parameters.asked_prior is None else {"asked_prior": parameters.asked_prior}
    if parameters.cover_prior is not None:
        if missing := set(get_args(CoverKey)) - set(parameters.cover_prior):
            raise ValueError(f"cover_prior lacks {', '.join(sorted(missing))}")
        tables |= {f"cover_prior.{key}": table for key, table in parameters.cover_prior.items()}
    for name, table in tables.items():
        if set(table) != set(ASKED):
            raise ValueError(f"{name} must have {', '.join(ASKED)}")
        yield from table.values()


def _cover_key(covered: bool) -> CoverKey:
    return "covered" if covered else "open"


def _known(what: str, known: tuple[str, ...], found: set[str]) -> None:
    if unknown := sorted(found - set(known)):
        raise ValueError(f'unknown {what} "{unknown[0]}"; known: {", ".join(known)}')


def _rows_on_one_line(json_text: str) -> str:
    """Lists of numbers take one line each, so that a table of counts reads like one."""
    innermost = re.compile(r"\[\s*([^\[\]{}\"]*?)\s*\]")
    return innermost.sub(lambda row: f"[{' '.join(row[1].split())}]", json_text)
