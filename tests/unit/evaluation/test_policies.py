"""The controls do what they say; the ablations are one switch each."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from recorded_table import RED, numbers
from scripted_table import CELL

from surefetch.common.conformal import conformal_set
from surefetch.common.errors import BadInput
from surefetch.common.hypotheses import AskedRelation
from surefetch.common.messages import (
    BeliefReply,
    Choice,
    Defer,
    Feasibility,
    Grasp,
    GraspVerdict,
    Inform,
    Target,
    Track,
)
from surefetch.evaluation.policies import registry
from surefetch.evaluation.policies.decision import gated
from surefetch.evaluation.policies.fixed_sequence import BestFixed, FixedSequence
from surefetch.evaluation.policies.greedy import Greedy
from surefetch.evaluation.policies.observation import Observation
from surefetch.planner.actions import State
from surefetch.planner.profiles import EXTENDED, PAPER

SURE = {"1:inside": 0.01, "1:outside": 0.95, "2:inside": 0.02, "2:outside": 0.0,
        "unobs": 0.01, "abs": 0.01}  # fmt: skip
RIVALS = {"1:inside": 0.0, "1:outside": 0.4, "2:inside": 0.45, "2:outside": 0.0,
          "unobs": 0.1, "abs": 0.05}  # fmt: skip
ABSENT = {"1:inside": 0.0, "1:outside": 0.01, "2:inside": 0.01, "2:outside": 0.0,
          "unobs": 0.01, "abs": 0.97}  # fmt: skip
DOUBTED = {"1:inside": 0.05, "1:outside": 0.09, "2:inside": 0.09, "2:outside": 0.08,
           "unobs": 0.09, "abs": 0.6}  # fmt: skip
VIEWS = ("right", "close_high")


def observe(
    belief: dict[str, float],
    *,
    asked: AskedRelation = "any",
    cover: State = "open",
    used: tuple[str, ...] = (),
    feasible: tuple[int, ...] = (1, 2),
    seed: int = 0,
) -> Observation:
    believed = BeliefReply(
        episode="e", step=0, tracks=tuple(_track(i) for i in (1, 2)), assigned=(), prior={},
        belief=belief, gamma=conformal_set(belief, 0.9), q_hat=0.9, digest="-",
    )  # fmt: skip
    return Observation(
        target=Target(noun=RED.noun, color=RED.color, relation=asked),
        cell=CELL,
        parameters=numbers("extended"),
        profile=EXTENDED,
        believed=believed,
        cover=cover,
        used=frozenset(used),
        given_up=frozenset(),
        feasibility=Feasibility(
            grasps=tuple(
                GraspVerdict(track=i, feasible=i in feasible, refusal=None, why="", tried={})
                for i in (1, 2)
            ),
            informs=(),
            duration_s=0.0,
        ),
        n_actions=0,
        rng=np.random.default_rng(seed),
    )


def _track(number: int) -> Track:
    return Track(
        id=number, center_world_m=(0.9, 0.1 * number, 0.0), solid=None,
        points_world_m=np.zeros((0, 3), np.float32), hist=None, n_observations=1, y0="MU",
        last_detection="d", last_step=0,
    )  # fmt: skip


def chosen(name: str, now: Observation) -> Choice | None:
    return registry.find(name).make().act(now)


def test_always_deferring_defers_even_when_sure() -> None:
    assert chosen("always-defer", observe(SURE)) == Defer()


def test_greedy_grasps_the_most_probable_that_is_open() -> None:
    assert chosen("greedy", observe(RIVALS)) == Grasp(track=2, relation="inside")
    assert chosen("greedy", observe(RIVALS, asked="outside")) == Grasp(track=1, relation="outside")
    assert chosen("greedy", observe(RIVALS, cover="covered")) == Grasp(track=1, relation="outside")
    assert chosen("greedy", observe(RIVALS, feasible=(1,))) == Grasp(track=1, relation="outside")


def test_greedy_defers_when_no_grasp_is_open() -> None:
    assert chosen("greedy", observe(RIVALS, feasible=())) == Defer()


def test_the_threshold_belongs_to_what_is_grasped() -> None:
    now = observe(RIVALS)
    assert Greedy(0.45).act(now) == Grasp(track=2, relation="inside")
    assert Greedy(0.46).act(now) == Defer()
    assert chosen("greedy-threshold", now) == Defer()


def test_exhaustive_look_looks_on_when_sure_and_ends_greedily() -> None:
    assert chosen("exhaustive-look", observe(SURE)) == Inform(name="right")
    assert chosen("exhaustive-look", observe(SURE, used=("right",))) == Inform(name="close_high")
    assert chosen("exhaustive-look", observe(SURE, cover="covered")) == Inform(name="remove_cover")
    assert chosen("exhaustive-look", observe(SURE, used=VIEWS)) == Grasp(
        track=1, relation="outside"
    )
    assert chosen("exhaustive-look", observe(RIVALS, used=VIEWS)) == Defer()


def test_cheapest_first_grasps_as_soon_as_the_gate_lets_it() -> None:
    assert chosen("cheapest-first", observe(SURE)) == Grasp(track=1, relation="outside")
    assert chosen("cheapest-first", observe(RIVALS)) == Inform(name="right")
    assert chosen("cheapest-first", observe(RIVALS, used=VIEWS)) == Defer()
    assert chosen("cheapest-first", observe(SURE, feasible=(2,))) == Inform(name="right")


def test_the_least_belief_for_a_grasp_holds_for_whoever_is_gated() -> None:
    now = observe(SURE, used=VIEWS)
    careful = replace(now, parameters=msgspec.structs.replace(now.parameters, commit_at_least=0.96))
    for name in ("cheapest-first", "ours"):
        assert chosen(name, now) == Grasp(track=1, relation="outside")
        assert chosen(name, careful) == Defer()


def test_chance_takes_every_admissible_action_and_no_other() -> None:
    taken = {chosen("random", observe(SURE, seed=seed)) for seed in range(60)}
    assert taken == {
        Grasp(track=1, relation="outside"), Inform(name="right"), Inform(name="close_high")
    }  # fmt: skip
    at_the_end = {chosen("random", observe(RIVALS, used=VIEWS, seed=seed)) for seed in range(9)}
    assert at_the_end == {Defer()}


def test_chance_may_defer_when_only_absence_is_left() -> None:
    taken = {chosen("random", observe(ABSENT, seed=seed)) for seed in range(60)}
    assert Defer() in taken


def test_the_least_belief_in_absence_holds_for_whoever_is_gated() -> None:
    """Absence is alone in the conformal set, and less likely than `extended` asks."""
    now = observe(DOUBTED)
    assert now.believed.gamma == ("abs",)
    by_the_paper = replace(now, profile=PAPER)
    assert gated(now) == [Inform(name="right"), Inform(name="close_high")]
    assert Defer() in gated(by_the_paper)
    assert Defer() not in {chosen("random", observe(DOUBTED, seed=seed)) for seed in range(60)}
    assert Defer() in gated(observe(ABSENT))


def test_without_the_gate_rivals_are_grasped_and_without_defer_nothing_is_left() -> None:
    """A6, A7 and A8 where looking is over and two hypotheses remain."""
    now = observe(RIVALS, used=VIEWS)
    assert chosen("ours", now) == Defer()
    assert chosen("a6", now) == Grasp(track=2, relation="inside")
    assert chosen("a7", now) is None
    assert chosen("a8", now) == Grasp(track=2, relation="inside")


def test_each_ablation_differs_from_the_full_method_and_from_the_others() -> None:
    names = ["ours", *(f"a{n}" for n in range(1, 9))]
    entries = [registry.POLICIES[name] for name in names]
    assert len({(repr(entry.make()), entry.variant) for entry in entries}) == len(names)
    assert registry.POLICIES["a2"].make() == registry.POLICIES["ours"].make()


def test_a_policy_of_the_user_s_own_is_found() -> None:
    entry = registry.find("surefetch.evaluation.policies.always_defer:AlwaysDefer")
    assert entry.make().act(observe(SURE)) == Defer()
    assert entry.variant == "full"


@pytest.mark.parametrize(
    "name", ["our", "no.such.module:Class", "surefetch.evaluation.policies.greedy:Nothing", ":X"]
)
def test_an_unknown_policy_is_refused(name: str) -> None:
    with pytest.raises(BadInput, match=r"ours|installed"):
        registry.find(name)


def test_without_opening_for_what_is_outside_the_cover_stays_on() -> None:
    name = "exhaustive-look-if-inside"
    assert chosen(name, observe(SURE, cover="covered")) == Inform(name="remove_cover")
    asked = observe(SURE, cover="covered", asked="outside")
    assert chosen("exhaustive-look", asked) == Inform(name="remove_cover")
    assert chosen(name, asked) == Inform(name="right_covered")


def test_a_fixed_sequence_goes_on_after_what_is_not_open_and_ends_greedily() -> None:
    policy = FixedSequence(("right", "close_high"), 0.5)
    assert policy.act(observe(RIVALS)) == Inform(name="right")
    assert policy.act(observe(RIVALS, used=("right",))) == Inform(name="close_high")
    assert policy.act(observe(RIVALS, used=VIEWS)) == Defer()
    assert policy.act(observe(SURE, used=VIEWS)) == Grasp(track=1, relation="outside")


def test_the_best_sequence_is_that_of_the_first_look() -> None:
    policy = BestFixed(sequences={"covered, any asked": ("remove_cover",), "open, any asked": ()})
    assert policy.act(observe(SURE, cover="covered")) == Inform(name="remove_cover")
    assert policy.act(observe(SURE, used=("remove_cover",))) == Grasp(track=1, relation="outside")
