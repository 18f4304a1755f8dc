"""The JSON that programs read has the promised keys, and only JSON's own values."""

import json

import made_up_episode

from surefetch.common.messages import Status
from surefetch.evaluation.running import summary
from surefetch.evaluation.running.scoring import Score

PROMISED = set(
    "episode scene instruction understood profile policy outcome reason because correct delivered "
    "track actions steps q_hat durations services".split()
)
STATUS = Status(
    service="belief",
    boot="b",
    pid=7,
    host="here",
    version="0.1.0",
    backend="filter",
    doing="",
    n_served=3,
)


def test_every_promised_key_is_there_and_can_be_written() -> None:
    told = summary.summarize(
        scene="covered:1",
        instruction="the red cylinder",
        profile="extended",
        policy="ours",
        accepted=made_up_episode.observed().accepted,
        ended=made_up_episode.ended(),
        score=Score("success", True),
        wall_s=9.5,
        services={"belief": STATUS},
        missing=(),
    )
    assert told.keys() >= PROMISED
    read = json.loads(json.dumps(told, allow_nan=False))
    assert read["services"] == {"belief": {"pid": 7, "host": "here"}}
    assert read["actions"][0] == {"action": "right", "status": "done", "duration_s": 4.0}
    assert set(read["steps"][0]) == {"q", "observations", "belief", "gamma", "q_values"}


def test_an_episode_cut_short_can_be_written_too() -> None:
    told = summary.summarize(
        scene="covered:1",
        instruction="the red cylinder",
        profile="extended",
        policy="ours",
        accepted=None,
        ended=summary.cut_short("aborted", "service_lost", "belief died"),
        score=Score("aborted", False),
        wall_s=1.0,
        services={},
        missing=("frames",),
    )
    assert json.loads(json.dumps(told, allow_nan=False))["q_hat"] == "inf"
    assert summary.exit_code(told["outcome"]) == 3
