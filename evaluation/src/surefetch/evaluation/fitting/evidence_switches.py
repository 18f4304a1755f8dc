"""The switches of the profile `extended`: each replaces one part of fitted parameters. Pure."""

from collections.abc import Callable, Collection, Sequence
from typing import Final

from msgspec.structs import replace

from surefetch.common.hypotheses import ABS, ASKED, UNOBS, AskedRelation
from surefetch.common.parameters import BeliefPriors, CoverKey, Parameters
from surefetch.evaluation.fitting import fit, fit_births, fit_evidence
from surefetch.evaluation.recordings.story import Story, log_score, total

TEMPERINGS: Final = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)
COMPANY_WEIGHT: Final = 0.5
"""Chosen on development: with 1 the held-out log score is the same, but twice as many beliefs above
0.9 are wrong."""
BACK_OFF: Final = 2.0
"""Scenes that the priors of all with the same asked relation count for."""


def asked_prior(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """The relation weights and the first masses of the stories that ask the same.

    The birth coefficient stays that of all: to condition it, too, lowered the log score.
    """
    return replace(off, asked_prior={asked: _prior(off, stories, asked) for asked in ASKED})


def _prior(off: Parameters, stories: Sequence[Story], asked: AskedRelation) -> BeliefPriors:
    found = fit.priors(_total([story for story in stories if story.asked == asked]))
    return BeliefPriors(
        relation={"inside": found["inside"], "outside": 1.0 - found["inside"]},
        absent=found["abs"],
        unobserved=found["unobs"],
        tracked=1.0 - found["abs"] - found["unobs"],
        birth=off.priors.birth,
    )


def cover_prior(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """The same of the stories that also begin alike, covered or not.

    Few do, so the shares are drawn towards those of all that ask the same.
    """
    table: dict[CoverKey, dict[AskedRelation, BeliefPriors]] = {"open": {}, "covered": {}}
    for cover, by_asked in table.items():
        alike = [story for story in stories if story.covered == (cover == "covered")]
        for asked in ASKED:
            counts = _total([story for story in alike if story.asked == asked])
            by_asked[asked] = _drawn(counts, off.belief_priors(asked))
    return replace(off, cover_prior=table)


def _drawn(counts: fit.Counts, towards: BeliefPriors) -> BeliefPriors:
    """Shares of the counts, and of BACK_OFF more that are as expected."""

    def share(hits: int, trials: int, expected: float) -> float:
        return (hits + BACK_OFF * expected) / (trials + BACK_OFF)

    scenes, inside = counts.first.total(), counts.relation["inside"]
    absent = share(counts.first[ABS], scenes, towards.absent)
    unobserved = share(counts.first[UNOBS], scenes, towards.unobserved)
    inside_share = share(inside, counts.relation.total(), towards.relation["inside"])
    return replace(
        towards,
        relation={"inside": inside_share, "outside": 1.0 - inside_share},
        absent=absent,
        unobserved=unobserved,
        tracked=1.0 - absent - unobserved,
    )


def _total(stories: Sequence[Story]) -> fit.Counts:
    return total(stories, "extended")


def attribute_evidence(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """Each answer counted by what the body under it is."""
    return replace(off, attribute_evidence=fit_evidence.tables(_answers(stories)))


def company(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """What stands on tables without a target.

    It adds to the attribute evidence; without that it stays off.
    """
    if off.attribute_evidence is None:
        return off
    return replace(off, company=fit_evidence.company(_answers(stories), COMPANY_WEIGHT))


def _answers(stories: Sequence[Story]) -> fit_evidence.AnswerCounts:
    return sum((story.answers for story in stories), fit_evidence.AnswerCounts())


def births(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """New tracks by look and cover state, over all sequences."""
    return replace(off, births=fit_births.birth_table(_total(stories).new_tracks))


def tempering(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """The exponent under which the stories' truths are likeliest."""
    tempered = [replace(off, tempering=gamma) for gamma in TEMPERINGS]
    return max(tempered, key=lambda one: sum(log_score(story, one) for story in stories))


SWITCHES: Final[dict[str, Callable[[Parameters, Sequence[Story]], Parameters]]] = {
    "asked_prior": asked_prior,
    "cover_prior": cover_prior,
    "attribute_evidence": attribute_evidence,
    "births": births,
    "company": company,
    "tempering": tempering,
}
"""In the order in which they are turned on: priors are drawn towards those before
them, and the exponent belongs to all others."""


def turned_on(off: Parameters, stories: Sequence[Story], on: Collection[str]) -> Parameters:
    """Parameters with these switches on, fitted on the stories."""
    for name, switch in SWITCHES.items():
        if name in on:
            off = switch(off, stories)
    return off
