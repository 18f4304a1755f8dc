"""A decision problem as a POMDPX document, for other solvers. Pure.

The hidden state is the hypothesis, which never changes. Cover, used actions and the number of looks
taken are fully observed; `done` ends the episode. A look that is open costs what it costs and shows
one symbol of one track. Whatever else is taken ends the episode, and so does what is not open, at
the cost of a stalled episode, which is more than abstaining ever costs.

Solvers want a discount below one, and the costs have none. So rewards after t looks are divided by
the t-th power of the discount, and sum to undiscounted costs.

Source: PomdpX File Format (Version 1.0), National University of Singapore.
"""

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np

from surefetch.common.cell import InformRow
from surefetch.planner import actions, pomdpx_xml
from surefetch.planner.futures import Array
from surefetch.planner.pomdpx_value import likelihoods, masses_of, refuse_what_cannot_be_said
from surefetch.planner.pomdpx_words import DEFER, DONE, NOT_YET, NOTHING, STATES, USED, Words
from surefetch.planner.pomdpx_xml import WITHOUT_PARENTS, Entry
from surefetch.planner.problem import Problem

DISCOUNT: Final = 0.95

DESCRIPTION: Final = """\
surefetch, decision problem "{name}": which object is the target, and when is that sure enough?

Hidden: hypothesis. t3_inside: track 3 is the target and stands inside the container; unobs: the
target is there and has no track; abs: it is not there. Fully observed: cover; used_A, whether look
A was taken; looks, n0 to n{horizon} for how many were taken, or done.
A look shows one symbol of one track; each track is as likely as another.{unreachable}
What is not open in a state ends the episode at the cost {stalled:g}, more than defer ever costs.

Two rules of surefetch hang on the belief and are NOT here: a grasp must be alone in the conformal
set (and be of the three heaviest tracks, in the likelier relation), and defer is open only when
nothing is left to look at or the set says absent. So the value here is at best what surefetch
reaches; `surefetch solve --export` prints it.

Rewards are negative costs. Those after t looks are divided by {discount:g}^t, so that the
discounted sum of rewards is the undiscounted sum of costs, negated."""


def document(problem: Problem, name: str) -> bytes:
    """The problem in POMDPX.

    Args:
        problem: the conformal threshold and `no_conformal` have no effect.
        name: of the problem, any text.

    Raises:
        ValueError: see `pomdpx_value.refuse_what_cannot_be_said`.
    """
    refuse_what_cannot_be_said(problem)
    words = Words.of(problem)
    root = pomdpx_xml.empty_document(_description(problem, name), DISCOUNT)
    _add_variables(ET.SubElement(root, "Variable"), words)
    _add_start(ET.SubElement(root, "InitialStateBelief"), problem, words)
    _add_transitions(ET.SubElement(root, "StateTransitionFunction"), problem, words)
    shown = ("action", "looks_1", "hypothesis_1"), _seen(problem, words)
    pomdpx_xml.add_chances(ET.SubElement(root, "ObsFunction"), "seen", *shown)
    earned = ("action", *words.observed, "hypothesis_0"), _rewards(problem, words)
    pomdpx_xml.add_rewards(ET.SubElement(root, "RewardFunction"), "reward", *earned)
    return pomdpx_xml.written(root)


def _description(problem: Problem, name: str) -> str:
    far = [f"t{i}" for i in problem.belief.tracks if i not in problem.feasible]
    return DESCRIPTION.format(
        name=name,
        horizon=problem.horizon,
        stalled=problem.costs.stalled,
        discount=DISCOUNT,
        unreachable=f"\nBefore the first look {', '.join(far)} cannot be grasped." if far else "",
    )


def _add_variables(at: ET.Element, words: Words) -> None:
    pomdpx_xml.add_state(at, "looks", (*words.looks, DONE), observed=True)
    pomdpx_xml.add_state(at, "cover", STATES, observed=True)
    for row in words.rows:
        pomdpx_xml.add_state(at, f"used_{row.name}", (NOT_YET, USED), observed=True)
    pomdpx_xml.add_state(at, "hypothesis", words.hypotheses, observed=False)
    pomdpx_xml.add_named(at, "ObsVar", "seen", words.symbols)
    pomdpx_xml.add_named(at, "ActionVar", "action", words.actions)
    ET.SubElement(at, "RewardVar", vname="reward")


def _add_start(at: ET.Element, problem: Problem, words: Words) -> None:
    _add_surely(at, "looks", (*words.looks, DONE), words.looks[0])
    _add_surely(at, "cover", STATES, problem.state)
    for row in words.rows:
        _add_surely(at, f"used_{row.name}", (NOT_YET, USED), NOT_YET)
    belief = ("-",), tuple(masses_of(problem))
    pomdpx_xml.add_chances(at, "hypothesis_0", WITHOUT_PARENTS, [belief])


def _add_surely(at: ET.Element, name: str, values: Iterable[str], known: str) -> None:
    certain = ("-",), tuple(float(value == known) for value in values)
    pomdpx_xml.add_chances(at, f"{name}_0", WITHOUT_PARENTS, [certain])


def _add_transitions(at: ET.Element, problem: Problem, words: Words) -> None:
    pomdpx_xml.add_chances(at, "looks_1", ("action", *words.observed), _steps(words))
    pomdpx_xml.add_chances(at, "cover_1", ("action", "cover_0"), _covers(problem, words))
    for row in words.rows:
        name = f"used_{row.name}"
        pomdpx_xml.add_chances(at, f"{name}_1", ("action", f"{name}_0"), _uses(row, words))
    kept = [((z, z), (1.0,)) for z in words.hypotheses]
    pomdpx_xml.add_chances(at, "hypothesis_1", ("hypothesis_0",), kept)


def _steps(words: Words) -> Iterator[Entry]:
    for row in words.rows:
        for before, after in zip(words.looks, words.looks[1:], strict=False):
            for where, is_open in words.cases(row):
                yield (row.name, before, *where, after if is_open else DONE), (1.0,)
        for before in (words.looks[-1], DONE):
            yield (row.name, before, *words.anywhere, DONE), (1.0,)
    for name in words.ends:
        yield (name, "*", *words.anywhere, DONE), (1.0,)


def _covers(problem: Problem, words: Words) -> Iterator[Entry]:
    for row in words.rows:
        for state in STATES:
            is_open = state == row.requires
            following = actions.transitions(row, state, problem.p_remove) if is_open else None
            for after, p in following or ((state, 1.0),):
                yield (row.name, state, after), (p,)
    for name in words.ends:
        yield from (((name, state, state), (1.0,)) for state in STATES)


def _uses(row: InformRow, words: Words) -> Iterator[Entry]:
    for name in words.actions:
        yield (name, NOT_YET, USED if name == row.name else NOT_YET), (1.0,)
        yield (name, USED, USED), (1.0,)


def _seen(problem: Problem, words: Words) -> Iterator[Entry]:
    for name in words.ends:
        yield (name, "*", "*", NOTHING), (1.0,)
    for row in words.rows:
        chances = likelihoods(problem, row)  # (hypotheses, symbols but for nothing)
        nothing = 1.0 if not problem.y0 else 0.0
        for looks in words.looks[1:]:
            for z, p in zip(words.hypotheses, chances, strict=True):
                yield (row.name, looks, z, "-"), (nothing, *p)
        for looks in (words.looks[0], DONE):
            yield (row.name, looks, "*", NOTHING), (1.0,)


def _rewards(problem: Problem, words: Words) -> Iterator[Entry]:
    """Nothing once the episode is over."""
    yield ("*", DONE, *words.anywhere, "*"), (0.0,)
    for t, looks in enumerate(words.looks):
        scale = -(DISCOUNT**-t)
        for instance, costs in _costs(problem, words, t):
            yield (instance[0], looks, *instance[1:]), tuple(scale * cost for cost in costs)


def _costs(problem: Problem, words: Words, t: int) -> Iterator[Entry]:
    """Undiscounted, of all actions after t looks."""
    stalled = problem.costs.stalled
    for row in words.rows:
        if t == problem.horizon:
            yield (row.name, *words.anywhere, "*"), (stalled,)
            continue
        for where, is_open in words.cases(row):
            yield (row.name, *where, "*"), (row.cost if is_open else stalled,)
    for grip in words.grips:
        reachable = t > 0 or grip.track in problem.feasible
        for state in STATES:
            is_open = reachable and actions.graspable(problem.asked, state)[grip.r]
            costs = (
                actions.grasp_cost(_surely(grip.column, words), problem.p_held, problem.costs)
                if is_open
                else np.full(len(words.hypotheses), stalled)
            )
            yield (grip.name, *words.within(state), "-"), tuple(costs)
    absent = _surely(len(words.hypotheses) - 1, words)
    yield (DEFER, *words.anywhere, "-"), tuple(actions.defer_cost(absent, problem.costs))


def _surely(column: int, words: Words) -> Array:
    """(hypotheses,): the probability of one of them, under each."""
    certain = np.zeros(len(words.hypotheses))
    certain[column] = 1.0
    return certain
