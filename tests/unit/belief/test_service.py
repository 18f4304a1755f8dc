"""The belief service: looks in order, each once, with numbers that belong to this cell."""

from collections.abc import Callable
from dataclasses import replace as fields_replaced
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from scripted_table import BACKEND, CELL, parameters

from surefetch.belief.episode import EpisodeBelief, rules_of, step
from surefetch.belief.service import BeliefService
from surefetch.common import codec
from surefetch.common.answer_tables import AnswerTables, Company, Has, LabelCounts
from surefetch.common.errors import BadInput, Refused
from surefetch.common.hypotheses import ASKED
from surefetch.common.messages import (
    Answer,
    Answers,
    BeliefReply,
    Box3d,
    Detection,
    Mask,
    Update,
)
from surefetch.common.parameters import (
    BeliefPriors,
    BirthCounts,
    Parameters,
    profile_parameters,
    write_parameters,
)

CENTER = (0.9, 0.0, 0.03)


def service() -> BeliefService:
    return BeliefService(parameters, CELL.name)


def with_evidence(profile: str) -> Parameters:
    """The same, with every switch on."""
    plain = parameters(profile)
    prior = BeliefPriors(
        relation={"inside": 0.99, "outside": 0.01},
        absent=0.1,
        unobserved=0.3,
        tracked=0.6,
        birth=0.9,
    )
    row: dict[str, dict[Has, LabelCounts]] = {
        "center": {"match": (80, 2, 18), "mismatch": (2, 80, 18)}
    }
    tables = AnswerTables(
        identity={"color": row, "shape": row, "marking": row},
        membership={"center": {"inside": (90, 1, 9), "outside": (1, 90, 9)}},
        distractors={},
    )
    by_asked = dict.fromkeys(ASKED, prior)
    born = BirthCounts(with_target=(3, 1), without=(9, 4, 2), still_unseen=5)
    return replace(
        plain,
        asked_prior=by_asked,
        cover_prior={"open": by_asked, "covered": by_asked},
        attribute_evidence=tables,
        births={"center": {"open": born}},
        company=Company(distractors={}, weight=0.5),
        tempering=0.25,
    )


def detection(
    name: str,
    at_m: tuple[float, float, float] | None = CENTER,
    color: str | None = "supported",
    membership: str = "outside",
) -> Detection:
    told = Answer(label=membership, scores=(0.0, 0.0, 0.0))
    answers = Answers(
        color=Answer(label=color or "", scores=(0.0, 0.0, 0.0)),
        shape=None,
        marking=None,
        membership=told,
    )
    return Detection(
        id=name,
        box_px=(0.0, 0.0, 1.0, 1.0),
        score=1.0,
        phrase="thing",
        mask=Mask(height=1, width=1, counts=(1,)),
        group=0,
        representative=True,
        center_world_m=at_m,
        solid=at_m and Box3d(center_world_m=at_m, size_m=(0.05, 0.05, 0.05), yaw_rad=0.0),
        points_world_m=np.zeros((0, 3), np.float32),
        hist=None,
        answers=None if color is None else answers,
    )


def update(seq: int, *detections: Detection, counted: bool = True, episode: str = "e") -> Update:
    return Update(
        episode=episode,
        step=seq,
        obs_seq=seq,
        profile="extended",
        backend=BACKEND,
        q="center",
        asked="any",
        counted=counted,
        detections=detections,
    )


def encoded(reply: BeliefReply) -> bytes:
    return codec.encode(reply, max_bytes=1 << 20)


def test_a_repeated_look_gets_the_stored_reply_and_changes_nothing() -> None:
    belief = service()
    first = belief.handle(update(0, detection("a")))
    second = belief.handle(update(1, detection("b")))
    assert encoded(belief.handle(update(0, detection("a")))) == encoded(first)
    assert encoded(belief.handle(update(1, detection("b")))) == encoded(second)
    plain = service()
    for look in (update(0, detection("a")), update(1, detection("b"))):
        plain.handle(look)
    third = update(2, detection("c"))
    assert encoded(belief.handle(third)) == encoded(plain.handle(third))


def test_another_look_with_a_used_number_is_refused() -> None:
    belief = service()
    belief.handle(update(0, detection("a")))
    with pytest.raises(Refused) as refused:
        belief.handle(update(0, detection("other")))
    assert refused.value.reason == "ID_REUSED"


@pytest.mark.parametrize("seq", [2, 5])
def test_a_gap_is_refused_and_changes_nothing(seq: int) -> None:
    belief = service()
    first = belief.handle(update(0, detection("a")))
    with pytest.raises(Refused) as refused:
        belief.handle(update(seq, detection("b")))
    assert refused.value.reason == "OUT_OF_ORDER"
    assert "look 1" in str(refused.value)
    assert encoded(belief.handle(update(0, detection("a")))) == encoded(first)


def test_an_unknown_episode_must_begin_at_its_beginning() -> None:
    belief = service()
    belief.handle(update(0, detection("a")))
    with pytest.raises(Refused) as refused:
        belief.handle(update(1, detection("b"), episode="another"))
    assert refused.value.reason == "OUT_OF_ORDER"


def test_a_new_episode_starts_fresh() -> None:
    belief = service()
    for seq, name in enumerate("abc"):
        belief.handle(update(seq, detection(name)))
    fresh = belief.handle(update(0, detection("d"), episode="another"))
    alone = service().handle(update(0, detection("d"), episode="another"))
    assert encoded(fresh) == encoded(alone)


def test_a_look_that_does_not_count_moves_geometry_and_not_the_belief() -> None:
    belief = service()
    first = belief.handle(update(0, detection("a")))
    moved = (0.92, 0.01, 0.03)
    again = belief.handle(update(1, detection("b", moved, "contradicted"), counted=False))
    (track,) = again.tracks
    assert track.center_world_m == moved
    assert (track.y0, track.n_observations) == ("MO", 1)
    assert again.belief == pytest.approx(first.belief, rel=1e-12)
    (assigned,) = again.assigned
    assert (assigned.y, assigned.counted) == ("mismatch", False)


def test_a_look_that_does_not_count_still_finds_new_objects() -> None:
    belief = service()
    belief.handle(update(0, detection("a")))
    again = belief.handle(update(1, detection("b", (0.9, 0.25, 0.03)), counted=False))
    assert [t.id for t in again.tracks] == [1, 2]
    assert again.tracks[1].y0 is None
    assert again.belief["2:outside"] > 0.0


def test_a_detection_without_a_centre_is_dropped_and_said_to_be() -> None:
    reply = service().handle(update(0, detection("a", None), detection("b")))
    assert [(a.detection, a.track, a.counted) for a in reply.assigned] == [
        ("a", None, False),
        ("b", 1, True),
    ]


def test_an_unanswered_detection_is_tracked_and_tells_nothing() -> None:
    reply = service().handle(update(0, detection("a", color=None)))
    (track,) = reply.tracks
    assert (track.y0, track.n_observations) == (None, 0)
    assert reply.belief == pytest.approx(reply.prior, rel=1e-12)


def test_y0_is_the_latest_counted_observation() -> None:
    belief = service()
    belief.handle(update(0, detection("a", color="unobservable")))
    belief.handle(update(1, detection("b", color="supported", membership="unknown")))
    reply = belief.handle(update(2, detection("c", color="contradicted"), counted=False))
    assert (reply.tracks[0].y0, reply.tracks[0].n_observations) == ("MU", 2)


def test_a_first_look_at_nothing_believes_in_no_track() -> None:
    reply = service().handle(update(0))
    assert reply.belief == {"unobs": pytest.approx(22 / 27), "abs": pytest.approx(5 / 27)}


def test_numbers_of_another_perception_are_refused_with_the_command_that_fits_new_ones() -> None:
    look = replace(update(0, detection("a")), backend="another")
    with pytest.raises(BadInput, match="surefetch study fit"):
        service().handle(look)


def test_numbers_of_another_cell_are_refused() -> None:
    with pytest.raises(BadInput, match='this is cell "elsewhere"'):
        BeliefService(parameters, "elsewhere").handle(update(0, detection("a")))


def test_the_digest_tells_apart_what_was_learnt_of_a_track() -> None:
    rules = rules_of(with_evidence("extended"), "any")
    before, _ = step(EpisodeBelief(rules), update(0, detection("a")))
    other = fields_replaced(
        before, memory=fields_replaced(before.memory, known={1: (1.0, *[0.0] * 15)})
    )
    one, another = (step(belief, update(1))[1] for belief in (before, other))
    assert encoded(replace(one, digest="")) == encoded(replace(another, digest=""))
    assert one.digest != another.digest


def test_a_relation_that_is_asked_for_has_its_own_priors() -> None:
    belief = BeliefService(with_evidence, CELL.name)
    look = replace(update(0, detection("a", color=None)), asked="inside")
    prior = belief.handle(look).prior
    assert prior["1:inside"] == pytest.approx(0.6 * 0.99)
    assert (prior["unobs"], prior["abs"]) == (0.3, 0.1)


shifts = st.floats(-0.02, 0.02)
colors = st.sampled_from(["supported", "contradicted", "unobservable"])


@settings(deadline=None, max_examples=40)
@given(
    st.sampled_from([parameters, with_evidence]),
    st.lists(st.lists(st.tuples(shifts, colors), max_size=3), min_size=1, max_size=4),
)
def test_the_same_looks_give_the_same_bits_live_and_as_a_library(
    numbers: Callable[[str], Parameters],
    looks: list[list[tuple[float, str]]],
) -> None:
    live = BeliefService(numbers, CELL.name)
    library = EpisodeBelief(rules_of(numbers("extended"), "any"))
    digests = set()
    for seq, seen in enumerate(looks):
        found = [
            detection(f"{seq}-{i}", (0.8 + 0.15 * i + shift, 0.0, 0.03), color)
            for i, (shift, color) in enumerate(seen)
        ]
        reply = live.handle(update(seq, *found))
        library, same = step(library, update(seq, *found))
        assert encoded(same) == encoded(reply)
        digests.add(reply.digest)
    assert len(digests) == len(looks)


def test_gamma_is_the_conformal_set_of_the_profile_that_was_asked_for() -> None:
    strict = BeliefService(partial(parameters, q_hat=0.3), CELL.name)
    reply = strict.handle(update(0, detection("a")))
    assert reply.q_hat == 0.3
    assert reply.gamma == tuple(z for z, p in reply.belief.items() if 1 - p <= 0.3)


def test_numbers_come_from_the_folder_that_is_named_else_from_the_shipped_files(
    tmp_path: Path,
) -> None:
    own = parameters("paper")
    write_parameters(tmp_path / "paper.json", own)
    assert profile_parameters("paper", tmp_path) == own
    assert profile_parameters("paper", None).profile == "paper"
    with pytest.raises(BadInput, match="extended.json"):
        profile_parameters("extended", tmp_path)
    with pytest.raises(BadInput, match="Profiles: paper, extended"):
        profile_parameters("nonsense", tmp_path)
