"""An injected failure moves nothing, is said once, and leaves the next attempt as it was."""

from collections.abc import Iterator
from itertools import count

import numpy as np
import pytest
from msgspec import structs
from tabletop import body, estimate_of, scene

from surefetch.common.cell import simulated_cell
from surefetch.common.errors import Refused
from surefetch.common.local_bus import LocalBus, LocalCell
from surefetch.common.messages import (
    AskTruth,
    Command,
    Grasp,
    Inform,
    Injection,
    Look,
    Outcome,
    Stop,
    Truth,
    Verb,
)
from surefetch.common.settings import read_settings
from surefetch.common.topics import EXECUTE, EXECUTOR, LOAD_SCENE, STOP, TRUTH
from surefetch.executor.__main__ import EXECUTORS
from surefetch.executor.simulation.injected_failures import WHY

CELL = simulated_cell()
CUBE = scene(body("cube"))
GRASP = Grasp(track=0, relation="outside")


class Bench:
    """The simulated executor as it is wired, with a scene whose failures are given."""

    def __init__(self) -> None:
        bus = LocalBus(LocalCell(), EXECUTOR)
        self.service = EXECUTORS["pybullet"](read_settings([], EXECUTOR), bus)
        self.answers = {one.topic.name: one.answer for one in self.service.handles}
        self._ids = count()

    def load(self, *injected: Injection) -> None:
        self.answers[LOAD_SCENE.name](structs.replace(CUBE, injected=injected))

    def command(self, verb: Verb) -> Command:
        name = f"command {next(self._ids)}"
        return Command(cmd_id=name, episode="e", step=0, verb=verb, estimate=estimate_of(CUBE))

    def execute(self, command: Command) -> Outcome:
        outcome = self.answers[EXECUTE.name](command)
        assert isinstance(outcome, Outcome)
        return outcome

    def truth(self) -> Truth:
        told = self.answers[TRUTH.name](AskTruth())
        assert isinstance(told, Truth)
        return told


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    yield Bench()


def test_the_named_attempt_fails_without_a_motion_and_the_next_is_as_it_was(bench: Bench) -> None:
    bench.load(Injection(kind="grasp", occurrence=1))
    before = bench.truth()
    struck = bench.execute(bench.command(GRASP))
    assert (struck.status, struck.why, struck.motions, struck.holding) == ("failed", WHY, (), False)
    assert bench.truth().bodies == before.bodies
    assert bench.truth().touched == ()
    again = bench.execute(bench.command(GRASP))
    bench.load()
    plain = bench.execute(bench.command(GRASP))
    assert again.status == plain.status == "done"
    assert all(
        np.array_equal(a.q_rad, b.q_rad) for a, b in zip(again.motions, plain.motions, strict=True)
    )


def test_a_repeated_command_is_no_further_attempt(bench: Bench) -> None:
    bench.load(Injection(kind="view", occurrence=2))
    first, second = bench.command(Inform(name="right")), bench.command(Inform(name="right"))
    assert bench.execute(first).status == "done"
    assert bench.execute(first).status == "done"
    struck = bench.execute(second)
    assert struck.status == "failed"
    assert bench.execute(second) is struck
    with pytest.raises(Refused):
        bench.execute(structs.replace(second, verb=Inform(name="close_high")))
    assert bench.execute(bench.command(Inform(name="close_high"))).status == "done"


def test_a_look_that_verifies_is_no_attempt(bench: Bench) -> None:
    bench.load(Injection(kind="view", occurrence=1))
    assert bench.execute(bench.command(Look(view="right"))).status == "done"
    assert bench.execute(bench.command(Inform(name="close_high"))).status == "failed"


def test_a_stopped_executor_says_that_it_is_stopped(bench: Bench) -> None:
    bench.load(Injection(kind="view", occurrence=1))
    bench.answers[STOP.name](Stop(who="a test"))
    assert bench.execute(bench.command(Inform(name="right"))).status == "stopped"
    bench.load()
