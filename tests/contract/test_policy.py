"""What every policy promises: it does what is open to it, and draws from its own stream alone."""

import random
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_observation import Known, box, look, observation
from scripted_table import CELL

from surefetch.common.hypotheses import OBSERVATIONS
from surefetch.common.messages import Choice, Defer, Grasp, Inform
from surefetch.evaluation.policies import registry
from surefetch.evaluation.policies.observation import Observation, Policy
from surefetch.evaluation.recordings.free_space import FreeSpace

QUICKLY = {"simulations": 100.0}
"""Values of scalars that would make a policy slow."""
PLACES_M = ((0.85, 0.2), (0.95, -0.2), (1.05, 0.15), (0.9, -0.05))


@cache
def first_look() -> FreeSpace:
    return look("center", [box(*at_m) for at_m in PLACES_M])


@st.composite
def moments(draw: st.DrawFn) -> Observation:
    """Any belief, cover, used and failed actions, and reach."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(0, len(PLACES_M)))
    p = rng.gamma(draw(st.sampled_from([0.1, 0.5, 2.0])), size=2 * n + 2) + 1e-9
    p /= p.sum()
    known = [
        Known(
            draw(st.sampled_from((None, *OBSERVATIONS))),
            {"inside": float(p[2 * i]), "outside": float(p[2 * i + 1])},
            PLACES_M[i],
            feasible=draw(st.booleans()),
        )
        for i in range(n)
    ]
    profile = draw(st.sampled_from(("paper", "extended")))
    now = observation(
        known,
        asked=draw(st.sampled_from(("inside", "outside", "any"))),
        cover=draw(st.sampled_from(("open", "covered"))),
        unobs=float(p[-2]),
        looks=[first_look()],
        profile=profile,
    )
    names = [row.name for row in now.profile.rows(CELL)]
    used, lost = (frozenset(draw(st.sets(st.sampled_from(names)))) for _ in range(2))
    return replace(now, used=used, given_up=lost - used, n_actions=len(used))


def made(name: str) -> Policy:
    entry = registry.find(name)
    known = {scalar.name for scalar in entry.scalars}
    return entry.having(**{k: v for k, v in QUICKLY.items() if k in known}).make()


def acted(name: str, now: Observation, seed: int) -> Choice | None:
    """Python's own generator is somewhere else every time, and is left where it was."""
    before = random.getstate()
    choice = made(name).act(replace(now, rng=np.random.default_rng(seed)))
    assert random.getstate() == before
    random.random()
    return choice


@pytest.mark.parametrize("name", registry.POLICIES)
@settings(deadline=None, max_examples=15)
@given(now=moments())
def test_a_policy_does_what_is_open_and_the_same_for_the_same_stream(
    name: str, now: Observation
) -> None:
    choice = acted(name, now, seed=1)
    match choice:
        case Inform(name=row):
            assert row in {one.name for one in now.informs}
        case Grasp(track=track, relation=relation):
            assert (track, relation) in {(grip.track, grip.relation) for grip in now.grasps}
        case _:
            assert choice is None or choice == Defer()
    assert acted(name, now, seed=1) == choice
