"""Each failure is laid at the door where the target's story went wrong."""

import made_up_episode
import pytest
from msgspec.structs import replace

from surefetch.common.messages import Acted, Assigned, BeliefReply, Ended, Event
from surefetch.evaluation.running.causes import Findings, findings
from surefetch.evaluation.running.metrics import Verdict

DEFERRED = replace(
    made_up_episode.ended(), outcome="deferred", reason="nothing_left", track=None, relation=None
)
GRASPED = made_up_episode.ended()


def reply(
    step: int, assigned: dict[str, tuple[int | None, str]], belief: dict[str, float]
) -> BeliefReply:
    return BeliefReply(
        episode="e",
        step=step,
        tracks=(),
        assigned=tuple(
            Assigned(detection=detection, track=track, y=y, counted=True)
            for detection, (track, y) in assigned.items()
        ),
        prior={},
        belief=belief,
        gamma=tuple(belief),
        q_hat=0.9,
        digest="0",
    )


def found(
    verdict: Verdict,
    ended: Ended,
    replies: list[BeliefReply],
    under: dict[str, str | None],
    target: str | None = "a",
    events: tuple[Event, ...] = (),
) -> Findings:
    return findings(
        verdict,
        ended,
        events,
        replies,
        under,
        target=target,
        relation=None if target is None else "outside",
    )


def test_a_success_has_no_cause() -> None:
    assert found("success", GRASPED, [], {}).cause is None


def test_a_target_that_no_look_detected_was_missed_by_perception() -> None:
    replies = [reply(0, {"d": (1, "mismatch")}, {"unobs": 0.4})]
    told = found("false_defer", DEFERRED, replies, {"d": "b"})
    assert told.cause == "perception"
    assert told.looks[0].truth == "unobs" and told.looks[0].p_truth == 0.4


@pytest.mark.parametrize(
    ("answered", "cause"),
    [("mismatch", "perception"), ("MI", "perception"), ("MO", "belief"), ("UO", "belief")],
)
def test_a_wrong_answer_about_the_target_is_perceptions(answered: str, cause: str) -> None:
    replies = [reply(0, {"d": (1, answered)}, {"1:outside": 0.3, "abs": 0.3})]
    told = found("false_defer", DEFERRED, replies, {"d": "a"})
    assert told.cause == cause
    assert told.looks[0].seen == (f"1 {answered}",)
    assert told.looks[0].p_truth == 0.3


def test_a_target_in_two_tracks_was_associated_badly() -> None:
    replies = [
        reply(0, {"d": (1, "MO")}, {"1:outside": 0.3}),
        reply(1, {"e": (2, "MO")}, {"2:outside": 0.3}),
    ]
    told = found("false_defer", DEFERRED, replies, {"d": "a", "e": "a"})
    assert (told.cause, told.target_tracks) == ("association", (1, 2))


def test_another_body_that_was_told_to_fit_is_perceptions() -> None:
    replies = [reply(0, {"d": (1, "MO")}, {"1:outside": 0.9})]
    told = found("wrong_object", GRASPED, replies, {"d": "b"})
    assert (told.cause, told.grasped_body) == ("perception", "b")


def test_another_body_that_was_not_told_to_fit_is_the_beliefs() -> None:
    replies = [reply(0, {"d": (1, "UO")}, {"1:outside": 0.9})]
    assert found("wrong_object", GRASPED, replies, {"d": "b"}).cause == "belief"


def test_a_track_of_two_bodies_was_associated_badly() -> None:
    replies = [
        reply(0, {"d": (1, "MO")}, {"1:outside": 0.3}),
        reply(1, {"e": (1, "MO")}, {"1:outside": 0.3}),
    ]
    assert found("wrong_object", GRASPED, replies, {"d": "b", "e": "c"}).cause == "association"


def test_fingers_on_a_neighbour_are_an_error_of_execution() -> None:
    replies = [reply(0, {"d": (1, "MO")}, {"1:outside": 0.9})]
    assert found("wrong_object", GRASPED, replies, {"d": "a"}).cause == "execution"


def test_an_action_that_failed_is_named() -> None:
    acted = Acted(cmd_id="c", action="grasp", status="failed", why="it slipped", duration_s=1.0)
    events = (Event(episode="e", seq=0, step=2, happening=acted),)
    told = found("grasp_failed", GRASPED, [], {}, events=events)
    assert (told.cause, told.why) == ("execution", "step 2: grasp failed: it slipped")
