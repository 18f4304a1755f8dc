"""The switches of the profile `extended`: each replaces one part of fitted parameters. Pure."""

from collections.abc import Callable, Collection, Sequence
from typing import Final

from msgspec.structs import replace

from surefetch.common.hypotheses import ASKED, AskedRelation
from surefetch.common.parameters import BeliefPriors, Parameters
from surefetch.evaluation.fitting import fit, fit_evidence
from surefetch.evaluation.recordings.story import Story, log_score, total

TEMPERINGS: Final = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0)


def asked_prior(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """The relation weights and the first masses of the stories that ask the same.

    The birth coefficient stays that of all: to condition it, too, lowered the log score.
    """
    return replace(off, asked_prior={asked: _prior(off, stories, asked) for asked in ASKED})


def _prior(off: Parameters, stories: Sequence[Story], asked: AskedRelation) -> BeliefPriors:
    found = fit.priors(total([story for story in stories if story.asked == asked]))
    return BeliefPriors(
        relation={"inside": found["inside"], "outside": 1.0 - found["inside"]},
        absent=found["abs"],
        unobserved=found["unobs"],
        tracked=1.0 - found["abs"] - found["unobs"],
        birth=off.priors.birth,
    )


def attribute_evidence(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """Each answer counted by what the body under it is."""
    counts = sum((story.answers for story in stories), fit_evidence.AnswerCounts())
    return replace(off, attribute_evidence=fit_evidence.tables(counts))


def tempering(off: Parameters, stories: Sequence[Story]) -> Parameters:
    """The exponent under which the stories' truths are likeliest in the end."""
    tempered = [replace(off, tempering=gamma) for gamma in TEMPERINGS]
    return max(tempered, key=lambda one: sum(log_score(story, one) for story in stories))


SWITCHES: Final[dict[str, Callable[[Parameters, Sequence[Story]], Parameters]]] = {
    "asked_prior": asked_prior,
    "attribute_evidence": attribute_evidence,
    "tempering": tempering,
}
"""In the order in which they are turned on: the exponent belongs to the other two."""


def turned_on(off: Parameters, stories: Sequence[Story], on: Collection[str]) -> Parameters:
    """Parameters with these switches on, fitted on the stories."""
    for name, switch in SWITCHES.items():
        if name in on:
            off = switch(off, stories)
    return off
