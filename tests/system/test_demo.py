"""`make demo`, as a stranger meets it: one command, four processes, a folder to look at."""

import json
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace
from PIL import Image
from rerun.chunk import RrdReader
from run_process import SERVICES, RunProcess, is_there

from surefetch.common import cli, codec
from surefetch.common.hypotheses import ABS
from surefetch.common.journal import Journal, JournalWriter, Record, read_journal
from surefetch.common.messages import BeliefReply, Captured, Motion
from surefetch.common.topics import LOAD_SCENE, TRUTH, UPDATE
from surefetch.evaluation.running import summary
from surefetch.evaluation.showing.observed_journal import read_observed

pytestmark = pytest.mark.system

EPISODE_S = 60.0
PROMISED = set(
    "episode scene instruction understood profile policy outcome reason because correct delivered "
    "track actions steps q_hat durations services".split()
)


@dataclass(frozen=True)
class Demo:
    """A run that is over."""

    status: int
    took_s: float
    pids: dict[str, int]
    own_pid: int
    out: str
    err: str
    folder: Path

    @property
    def told(self) -> dict[str, Any]:
        """The JSON on the last line of stdout."""
        found: dict[str, Any] = json.loads(self.out.splitlines()[-1])
        return found

    def journal(self, name: str) -> Journal:
        return read_journal(self.folder / "journal" / f"{name}.journal")


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Demo]:
    folder = tmp_path_factory.mktemp("demo")
    words = ["run", "--scene", "covered:1", "--out", "runs/demo", "--json"]
    began_s = time.monotonic()
    process = RunProcess(words, folder)
    try:
        pids: dict[str, int] = {}
        while process.process.poll() is None and set(pids) != set(SERVICES):
            pids = process.pids()
            time.sleep(0.05)
        status = process.wait(EPISODE_S)
        took_s = time.monotonic() - began_s
        yield Demo(
            status,
            took_s,
            pids,
            process.process.pid,
            process.text(),
            process.errors(),
            folder / "runs" / "demo",
        )
    finally:
        process.end()


def test_the_exit_code_comes_from_the_outcome(demo: Demo) -> None:
    assert demo.status == summary.exit_code(demo.told["outcome"])
    assert demo.told["outcome"] in ("grasped", "deferred")


def test_it_takes_less_than_a_minute(demo: Demo) -> None:
    assert demo.took_s < EPISODE_S


def test_the_json_is_the_last_line_and_has_the_promised_keys(demo: Demo) -> None:
    assert demo.told.keys() >= PROMISED
    assert demo.told == json.loads((demo.folder / "summary.json").read_text())
    assert len(demo.out.splitlines()) == 1
    assert demo.told["missing"] == []
    assert demo.told["scene"] == "covered:1"
    assert isinstance(demo.told["correct"], bool)


def test_progress_goes_where_no_program_reads(demo: Demo) -> None:
    for words in ("understood", "step 0", "Γ = {", "→ remove_cover"):
        assert words in demo.err
    assert "\x1b" not in demo.err


def test_four_processes_did_it_and_none_is_left(demo: Demo) -> None:
    told = {name: service["pid"] for name, service in demo.told["services"].items()}
    assert told == demo.pids
    assert set(told) == set(SERVICES)
    assert len({*told.values(), demo.own_pid}) == 5
    assert not any(is_there(pid) for pid in told.values())


def test_every_step_is_told(demo: Demo) -> None:
    steps = demo.told["steps"]
    assert steps[0]["q"] == "center"
    assert "after_removal" in [step["q"] for step in steps]
    for step in steps:
        assert sum(step["belief"].values()) == pytest.approx(1.0)
        assert step["q_values"]
    told = {action["action"]: action["status"] for action in demo.told["actions"]}
    assert told["remove_cover"] == "done"


def test_the_record_of_every_service_and_the_frames_are_kept(demo: Demo) -> None:
    for service in SERVICES:
        journal = demo.journal(service)
        assert journal.header.service == service
        assert journal.torn_bytes == 0
    seen = read_observed(demo.folder / "journal" / "observer.journal")
    captured = [e.happening.frame for e in seen.events if isinstance(e.happening, Captured)]
    assert set(seen.frames) == set(captured) == set(seen.observations)
    assert len(captured) >= len(demo.told["steps"]) > 0
    assert any(isinstance(message, Motion) for message in seen.log)


def test_no_truth_reaches_the_loop(demo: Demo) -> None:
    for service in ("perception", "belief", "planner"):
        topics = {record.topic for record in demo.journal(service).records}
        assert not topics & {LOAD_SCENE.name, TRUTH.name}
    asked = [r for r in demo.journal("executor").records if r.topic == TRUTH.name]
    assert asked == []  # the scorer asks when all journals are in


def test_the_recording_shows_all_of_it(demo: Demo) -> None:
    entities = {chunk.entity_path for chunk in RrdReader(demo.folder / "episode.rrd").stream()}
    assert entities >= {
        "/world/camera/image",
        "/world/camera/depth",
        "/world/camera/masks",
        "/world/points",
        "/world/container",
        "/world/arm/wrist_3",
        "/belief/absent",
        "/gamma",
        "/actions",
        "/decision",
    }


def test_the_trace_is_a_picture(demo: Demo) -> None:
    with Image.open(demo.folder / "trace.png") as picture:
        assert picture.width > 1000 and picture.height > 700


def test_its_decisions_are_the_same_when_taken_again(
    demo: Demo, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["replay", str(demo.folder), "--json"]) == 0
    told = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert told["same"] and len(told["decisions"]) == len(demo.told["steps"])


def test_a_changed_record_is_noticed(
    demo: Demo, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    changed = tmp_path / "changed"
    changed.mkdir()
    (changed / "summary.json").write_bytes((demo.folder / "summary.json").read_bytes())
    recorded = demo.journal("planner")
    writer = JournalWriter(changed / "journal" / "planner.journal", "planner", "changed")
    for record in recorded.records:
        body = bytes(record.body)
        if (record.kind, record.topic) == ("answer", UPDATE.name):
            body = codec.encode(_believing_in_absence(record), max_bytes=UPDATE.max_reply_bytes)
        writer.write(record.kind, record.topic, record.call, body)
    writer.close()
    assert cli.main(["replay", str(changed)]) == 1
    assert "different: now" in capsys.readouterr().out


def _believing_in_absence(record: Record) -> BeliefReply:
    """The belief service's answer, had it believed that nothing is there."""
    reply = record.message(BeliefReply)
    belief = dict.fromkeys(reply.belief, 0.0) | {ABS: 1.0}
    return replace(reply, belief=belief, gamma=(ABS,))


def test_its_view_can_be_rebuilt(demo: Demo, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["view", str(demo.folder), "--rebuild", "--no-open"]) == 0
    assert "rebuilt" in capsys.readouterr().out
