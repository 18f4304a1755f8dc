"""Which attempts are reported as failed depends on the episode's address and on nothing else."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import BadInput
from surefetch.common.injections import KINDS, Injector, kind_of, parse, told
from surefetch.common.messages import Deliver, Grasp, Inform, InjectedKind, Injection, Look, PutBack

kinds = st.sampled_from(KINDS)
CELL = simulated_cell()


@given(st.lists(kinds, max_size=12), kinds, st.integers(1, 4))
@settings(deadline=None)
def test_exactly_the_attempt_that_was_named_is_struck(
    attempts: list[InjectedKind], kind: InjectedKind, k: int
) -> None:
    injector = Injector("partial", 1, (Injection(kind=kind, occurrence=k),))
    struck = [n for n, attempt in enumerate(attempts) if injector.strikes(attempt)]
    mine = [n for n, attempt in enumerate(attempts) if attempt == kind]
    assert struck == mine[k - 1 : k]


@given(st.lists(kinds, max_size=12), st.floats(0.1, 1.0), st.integers(0, 2**40))
@settings(deadline=None)
def test_a_rate_strikes_the_same_attempts_whatever_is_attempted_between(
    attempts: list[InjectedKind], rate: float, seed: int
) -> None:
    injections = (Injection(kind="view", rate=rate),)
    among = Injector("partial", seed, injections)
    alone = Injector("partial", seed, injections)
    found = [(kind, among.strikes(kind)) for kind in attempts]
    views = [struck for kind, struck in found if kind == "view"]
    assert views == [alone.strikes("view") for _ in views]


@pytest.mark.parametrize(("rate", "low", "high"), [(0.2, 150, 250), (1.0, 1000, 1000)])
def test_failures_come_at_their_rate(rate: float, low: int, high: int) -> None:
    injections = (Injection(kind="view", rate=rate),)
    struck = [Injector("partial", seed, injections).strikes("view") for seed in range(1000)]
    assert low <= sum(struck) <= high


@given(st.lists(kinds, max_size=12))
def test_without_injections_nothing_is_struck(attempts: list[InjectedKind]) -> None:
    injector = Injector("partial", 1)
    assert not any(injector.strikes(kind) for kind in attempts)


def test_looks_deliveries_and_put_backs_are_never_struck() -> None:
    verbs = (Look(view="right"), Deliver(place="tray"), PutBack())
    assert [kind_of(verb, CELL) for verb in verbs] == [None] * 3
    named = (Inform(name="right"), Inform(name="remove_cover"), Grasp(track=1, relation="inside"))
    assert [kind_of(verb, CELL) for verb in named] == ["view", "cover", "grasp"]


@pytest.mark.parametrize("word", ["view@1", "grasp@2", "cover@0.25", "view@0.0001", "view@1.0"])
def test_what_is_injected_can_be_said_and_read(word: str) -> None:
    assert told([parse(word)]) == word


@pytest.mark.parametrize(
    "word", ["", "view", "view@", "view@0", "view@-1", "view@2.0", "view@1e-5", "lid@1"]
)
def test_what_cannot_be_injected_is_refused(word: str) -> None:
    with pytest.raises(BadInput, match="grasp@1"):
        parse(word)
