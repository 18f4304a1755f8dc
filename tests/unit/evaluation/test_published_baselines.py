"""RoboEXP, DovSG and ActPerMoMa do what EVALUATION says of them, line by line."""

from collections.abc import Sequence
from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_up_observation import COVERED, OPEN, Known, box, look, observation
from recorded_table import numbers, record
from scripted_table import CELL, Table, Thing, thing, thing_inside

from surefetch.common.hypotheses import ASKED, AskedRelation
from surefetch.common.injections import Injector
from surefetch.common.messages import Choice, Defer, Grasp, Inform, Target
from surefetch.evaluation.policies.actpermoma import ActPerMoMaLite, ActPerMoMaStrong, expected
from surefetch.evaluation.policies.dovsg import DovSgLite, DovSgStrong
from surefetch.evaluation.policies.matching import best, commit
from surefetch.evaluation.policies.object_memory import graph
from surefetch.evaluation.policies.roboexp import RoboExpLite, RoboExpStrong
from surefetch.evaluation.policies.unseen import Outlook
from surefetch.evaluation.recordings.free_space import FILLED, FREE, SHAPE, UNSEEN, FreeSpace
from surefetch.evaluation.replaying.beliefs import Beliefs
from surefetch.evaluation.replaying.episode import Errand, play
from surefetch.evaluation.replaying.outcomes import Drawn, Rates
from surefetch.evaluation.replaying.recorded_world import RecordedWorld
from surefetch.evaluation.replaying.scene import ready
from surefetch.planner.profiles import PROFILES

LITE = (RoboExpLite, DovSgLite, ActPerMoMaLite)
STRONG = (RoboExpStrong, DovSgStrong, ActPerMoMaStrong)
VIEWS = ("right", "close_high")
FREE_LOOK = FreeSpace.of(np.full(SHAPE, FREE, np.int8))
SEEN_CLEARLY = (FREE_LOOK,) * 3
"""After all views nothing is unseen."""


def grasp(track: int, relation: str = "outside") -> Grasp:
    return Grasp(track=track, relation=relation)  # type: ignore[arg-type]


# RoboEXP, literally


def test_roboexp_lite_opens_a_covered_container_first() -> None:
    sure = Known("MO", 0.99)
    assert RoboExpLite().act(observation([sure], cover="covered")) == Inform(name="remove_cover")
    assert RoboExpLite().act(observation([sure])) == grasp(1)


def test_roboexp_lite_takes_matches_on_the_table_before_those_in_the_container() -> None:
    tracks = [Known("mismatch"), Known("MI"), Known("MO"), Known("MO")]
    assert RoboExpLite().act(observation(tracks)) == grasp(3)
    assert RoboExpLite().act(observation(tracks, asked="inside")) == grasp(2, "inside")
    assert RoboExpLite().act(observation([Known("MI"), Known("MO", feasible=False)])) == grasp(
        1, "inside"
    )


@pytest.mark.parametrize("asked", ["inside", "outside"])
def test_roboexp_lite_takes_the_best_rank_that_can_be_grasped(asked: AskedRelation) -> None:
    fits, other = ("I", "O") if asked == "inside" else ("O", "I")
    ranks = ["mismatch", f"U{other}", "UU", f"U{fits}", "MU", f"M{fits}"]
    for n in range(1, len(ranks) + 1):
        assert RoboExpLite().act(observation(list(map(Known, ranks[:n])), asked=asked)) == grasp(
            n, asked
        )


def test_roboexp_lite_never_abstains_while_anything_can_be_grasped() -> None:
    assert RoboExpLite().act(observation([Known("mismatch")], asked="outside")) == grasp(1)
    assert RoboExpLite().act(observation([Known("MO", feasible=False)])) == Defer()


# RoboEXP, strong


def test_roboexp_strong_takes_the_newest_action_of_its_stack_first() -> None:
    """The cover was pushed before the views."""
    policy = RoboExpStrong()
    unread = observation([Known("UU", 0.3)], cover="covered", container=COVERED)
    chosen = policy.act(unread)
    assert chosen in [Inform(name=row.name) for row in CELL.covered_views]
    read = [Known("MO", 0.9)]
    seen = observation(read, cover="covered", used=["right_covered"], looks=SEEN_CLEARLY[:2])
    assert policy.act(seen) == Inform(name="remove_cover")


def test_roboexp_strong_opens_even_when_sure_and_then_asks_the_belief() -> None:
    policy, sure = RoboExpStrong(), [Known("MO", 0.9)]
    closed = observation(sure, cover="covered", looks=[FREE_LOOK])
    assert policy.act(closed) == Inform(name="remove_cover")
    opened = observation(sure, used=["remove_cover"], looks=SEEN_CLEARLY[:2])
    assert policy.act(opened) == grasp(1)


def test_roboexp_strong_looks_behind_what_hides_enough_and_no_further() -> None:
    stands = [box(0.9, 0.0, (0.08, 0.08, 0.15))]
    known = [Known("MO", 0.9, at_m=(0.9, 0.0))]
    now = observation(known, looks=[look("center", stands)])
    hidden_l = 1e-3 * len(Outlook(now).behind(now.believed.tracks[0]))
    assert isinstance(RoboExpStrong(hidden_l=0.99 * hidden_l).act(now), Inform)
    assert RoboExpStrong(hidden_l=1.01 * hidden_l).act(now) == grasp(1)


def test_roboexp_strong_looks_at_what_is_unread_until_it_is_read() -> None:
    for y, asked in (("UO", "any"), ("MU", "outside"), ("MU", "inside")):
        now = observation([Known(y, 0.9)], asked=asked, looks=[FREE_LOOK])  # type: ignore[arg-type]
        assert isinstance(RoboExpStrong().act(now), Inform)
    for y in ("MO", "MU", "mismatch"):
        now = observation([Known(y, 0.9)], looks=[FREE_LOOK])
        assert RoboExpStrong().act(now) == grasp(1)


# DovSG, literally


def test_dovsg_lite_never_opens() -> None:
    for known in ([], [Known("UU")], [Known("MI", at_m=(1.0, 0.0))]):
        policy = DovSgLite()
        now = observation(known, asked="inside", cover="covered", profile="paper")
        assert policy.act(now) == Defer()


def test_dovsg_lite_locates_looks_once_more_and_picks() -> None:
    policy = DovSgLite()
    assert policy.act(observation([Known("mismatch")])) == Inform(name="right")
    assert policy.act(observation([Known("mismatch"), Known("MO")], used=["right"])) == grasp(2)
    assert DovSgLite().act(observation([Known("MO")])) == grasp(1)


def test_dovsg_lite_defers_when_both_looks_located_nothing() -> None:
    policy = DovSgLite()
    policy.act(observation([Known("UU", 0.9)]))
    assert policy.act(observation([Known("UU", 0.9)], used=["right"])) == Defer()


def test_dovsg_lite_picks_the_match_nearest_to_the_container() -> None:
    away, near = Known("MO", at_m=(0.8, 0.25)), Known("MO", at_m=(0.85, 0.1))
    assert DovSgLite().act(observation([away, near])) == grasp(2)
    assert DovSgLite().act(observation([away, near], container=None)) == grasp(1)


# DovSG, strong


def test_dovsg_strong_confirms_what_it_does_not_know() -> None:
    sure = Known("MO", 0.9)
    assert DovSgStrong().act(observation([sure])) == grasp(1)
    for unknown in (Known("UU", 0.05), Known("mismatch", 0.0, last_step=0)):
        now = observation([sure, unknown], used=["right"], looks=SEEN_CLEARLY[:2])
        assert DovSgStrong().act(now) == Inform(name="close_high")
    unsure = observation([Known("MO", 0.7), Known("mismatch", 0.3)])
    assert isinstance(DovSgStrong(0.8).act(unsure), Inform)
    twice = Known("mismatch", 0.0, last_step=0, n_observations=2)
    now = observation([sure, twice], used=["right"], looks=SEEN_CLEARLY[:2])
    assert DovSgStrong().act(now) == grasp(1)


def test_dovsg_strong_opens_for_what_is_asked_inside_or_was_not_found() -> None:
    def chosen(known: Known, asked: AskedRelation) -> Choice:
        return DovSgStrong().act(
            observation([known], asked=asked, cover="covered", profile="paper")
        )

    removes = Inform(name="remove_cover")
    assert chosen(Known("MO", 0.9), "outside") == grasp(1)
    assert chosen(Known("MO", 0.3), "outside") == removes
    assert chosen(Known("MI", {"inside": 0.9}, at_m=(1.0, 0.0)), "inside") == removes


def test_dovsg_strong_picks_only_among_objects_with_the_asked_edge() -> None:
    """By where they stand, not by what was answered."""
    beside = Known("MI", {"inside": 0.6}, at_m=(0.8, 0.2))
    within = Known("MO", {"inside": 0.2}, at_m=(1.0, 0.0))
    now = observation([beside, within], asked="inside", used=VIEWS)
    assert DovSgStrong(0.15).act(now) == grasp(2, "inside")
    assert DovSgStrong(0.5).act(now) == Defer()


def test_dovsg_strong_forgets_what_newer_depth_contradicts() -> None:
    stands = [box(0.9, 0.2)]
    top = np.mgrid[0.88:0.92:9j, 0.18:0.22:9j, 0.055:0.06:2j].reshape(3, -1).T
    for later, n_kept in ((stands, 1), ([], 0)):
        looks = [look("center", stands), look("right", later)]
        now = observation([Known("MO", 0.9, last_step=0)], used=["right"], looks=looks)
        (known,) = now.believed.tracks
        known = msgspec.structs.replace(known, points_world_m=top.astype(np.float32))
        believed = msgspec.structs.replace(now.believed, tracks=(known,))
        assert len(graph(replace(now, believed=believed))) == n_kept


# ActPerMoMa, literally


def test_actpermoma_lite_looks_until_its_views_span_enough() -> None:
    match = [Known("MO", 0.9)]
    looked = Inform(name="right"), Inform(name="close_high")
    assert ActPerMoMaLite().act(observation(match)) in looked
    assert ActPerMoMaLite().act(observation(match, used=["close_high"])) == Inform(name="right")
    assert ActPerMoMaLite().act(observation(match, used=["right"])) == grasp(1)


def test_actpermoma_lite_looks_on_while_no_match_can_be_grasped() -> None:
    for known in (Known("UO", 0.9), Known("MO", 0.9, feasible=False)):
        assert ActPerMoMaLite().act(observation([known], used=["right"])) == Inform(
            name="close_high"
        )
        assert ActPerMoMaLite().act(observation([known], used=VIEWS)) == Defer()


def test_actpermoma_lite_grasps_what_the_last_frame_shows_and_can_be_grasped_best() -> None:
    tracks = [Known("MO", last_step=0), Known("MO", refused=3), Known("MO", refused=1)]
    assert ActPerMoMaLite().act(observation(tracks, used=VIEWS)) == grasp(3)
    assert ActPerMoMaLite().act(observation(tracks[:1], used=VIEWS)) == Defer()


def test_actpermoma_lite_never_opens() -> None:
    now = observation([], asked="inside", cover="covered", profile="paper")
    assert ActPerMoMaLite().act(now) == Defer()


@pytest.mark.parametrize(
    ("filled", "shown_by"),
    [
        ((slice(None), 35, slice(0, 13)), "close_high"),
        ((slice(27, 34), slice(37, 44), 12), "right"),
    ],
)
def test_actpermoma_lite_takes_the_view_that_shows_what_is_behind_a_surface(
    filled: tuple[slice | int, ...], shown_by: str
) -> None:
    """One unseen voxel, a surface beside it, and a wall to its right or a roof over it."""
    grid = np.full(SHAPE, FREE, np.int8)
    grid[29, 40, 2] = grid[filled] = FILLED
    grid[30, 40, 2] = UNSEEN
    now = observation([Known("MO")], looks=[FreeSpace.of(grid)], container=None)
    assert ActPerMoMaLite().act(now) == Inform(name=shown_by)


# ActPerMoMa, strong


@settings(deadline=None, max_examples=25)
@given(st.floats(0.0, 0.5), st.floats(0.0, 0.5), st.sampled_from(ASKED), st.booleans())
def test_what_is_expected_is_what_is_undecided(
    p: float, unobs: float, asked: AskedRelation, is_covered: bool
) -> None:
    """All of it lies where nothing was seen: the unseen target where it is asked for."""
    stands = [box(0.8, -0.2), OPEN.outer]
    now = observation(
        [Known("UO", p, at_m=(0.8, -0.2))], asked=asked, unobs=unobs,
        cover="covered" if is_covered else "open", looks=[look("center", stands)],
    )  # fmt: skip
    outlook, weight = Outlook(now), expected(Outlook(now))
    mass = 0.0 if asked == "inside" else p
    assert weight.sum() == pytest.approx(unobs + 4.0 * mass * (1.0 - mass))
    assert not weight[~outlook.unseen].any()
    about = np.zeros(len(weight), bool)
    about[outlook.about(now.believed.tracks[0])] = True
    assert asked != "inside" or not weight[~outlook.inside & ~about].any()
    assert asked != "outside" or not weight[outlook.inside & ~about].any()


def test_actpermoma_strong_opens_for_an_unseen_target_that_is_asked_inside() -> None:
    def chosen(unobs: float, asked: AskedRelation) -> Choice:
        return ActPerMoMaStrong().act(
            observation([], asked=asked, unobs=unobs, cover="covered", profile="paper",
                        container=COVERED, looks=[look("center", [OPEN.outer])])
        )  # fmt: skip

    assert chosen(0.6, "inside") == Inform(name="remove_cover")
    assert chosen(0.6, "outside") == Defer()
    assert chosen(0.2, "inside") == Defer()


def test_actpermoma_strong_looks_while_it_gains_and_its_views_span_too_little() -> None:
    known = [Known("MO", 0.6, at_m=(0.8, -0.2))]
    first = [look("center", [box(0.8, -0.2)])]
    assert isinstance(ActPerMoMaStrong().act(observation(known, looks=first)), Inform)
    assert ActPerMoMaStrong(min_gain=9.0).act(observation(known, looks=first)) == grasp(1)
    spanned = observation(known, used=["right"], looks=first * 2)
    assert ActPerMoMaStrong(min_gain=-9.0).act(spanned) == grasp(1)
    assert ActPerMoMaStrong(0.7, min_gain=-9.0).act(spanned) == Defer()


# What strong variants share


def test_what_is_believed_most_is_grasped_if_sure_and_possible() -> None:
    tracks = [Known("MO", {"inside": 0.6}), Known("mismatch", 0.3)]
    assert commit(observation(tracks), 0.6) == grasp(1, "inside")
    assert commit(observation(tracks), 0.61) == Defer()
    assert commit(observation(tracks, asked="outside"), 0.3) == grasp(2)
    assert commit(observation(tracks, cover="covered"), 0.3) == Defer()
    shut = [Known("MO", 0.6, feasible=False), Known("MO", 0.4)]
    assert commit(observation(shut), 0.3) == Defer()
    assert best(observation([])) is None


readings = st.sampled_from(["match", "other", "unread", "hidden"])
things = st.builds(
    lambda x_m, y_m, read, right, close_high, inside: (
        thing_inside(read, right=right, close_high=close_high)
        if inside
        else thing(x_m, y_m, read, right=right, close_high=close_high)
    ),
    st.floats(0.75, 0.85), st.floats(-0.3, 0.3), readings, readings, readings, st.booleans(),
)  # fmt: skip


@settings(deadline=None, max_examples=25)
@given(
    st.lists(things, max_size=4), st.sampled_from([None, False, True]), st.sampled_from(ASKED),
    st.sampled_from(list(PROFILES)), st.integers(100_000, 100_100),
)  # fmt: skip
def test_every_action_is_admissible_and_the_same_when_played_again(
    stand: Sequence[Thing], is_covered: bool | None, asked: AskedRelation, profile: str, seed: int
) -> None:
    """`play` refuses what is not open."""
    recorded = record(
        Table(stand, covered=is_covered), wanted=None, seed=seed,
        target=Target(noun="object", color="red", relation=asked),
    )  # fmt: skip
    scene = ready(*recorded)
    for make in (*LITE, *STRONG):
        taken = []
        for policy in (make(), make()):
            world = RecordedWorld(
                scene, Drawn("partial", seed, Rates()), Injector("partial", 0, ())
            )
            errand = Errand(scene.recording.target, CELL, numbers(profile), PROFILES[profile])
            beliefs = Beliefs(asked, scene.recording.backend, numbers(profile), "full", 0.9)
            played = play(policy, errand, world, beliefs, np.random.default_rng(0))
            assert played.end.outcome != "stalled"
            taken.append(played.taken)
        assert taken[0] == taken[1]
