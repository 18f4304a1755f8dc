"""An episode seen from outside ends in good order, whatever happens, and is collected whole."""

import os
import signal
import threading
from pathlib import Path

import made_up_episode
import pytest
from made_up_cell import MadeUpCell, made_up_cell

from surefetch.common.errors import Refused
from surefetch.common.journal import parse_journal
from surefetch.common.messages import Acting, Event, Instruct
from surefetch.common.topics import SERVICES
from surefetch.evaluation.running.cell import LiveCell
from surefetch.evaluation.running.live import Finished, Live
from surefetch.evaluation.showing.observed_journal import OBSERVER, read_observed

INSTRUCT = Instruct(sentence="the red cylinder", profile="extended", policy="ours")
SCENE = made_up_episode.scene()


def run(cell: MadeUpCell, folder: Path, **limits: float) -> tuple[Finished, list[Event]]:
    shown: list[Event] = []
    live = Live(LiveCell("made-up", (), cell.operator, {}, None, folder), **limits)
    return live.run(INSTRUCT, SCENE, shown.append), shown


class Holder:
    """Makes the planner wait at its first command until the test goes on."""

    def __init__(self, then: threading.Event) -> None:
        self.reached = threading.Event()
        self._then = then

    def __call__(self, event: Event) -> None:
        if isinstance(event.happening, Acting):
            self.reached.set()
            self._then.wait(5.0)


def test_a_whole_episode_is_shown_and_collected(tmp_path: Path) -> None:
    with made_up_cell(tmp_path) as cell:
        finished, shown = run(cell, tmp_path)
    assert finished.ended.outcome == "grasped"
    assert [event.seq for event in shown] == list(range(len(made_up_episode.events()) - 1))
    assert len(finished.observed.frames) == 2
    assert finished.missing == ()
    assert finished.truth is not None and finished.truth.touched == ("red cylinder",)
    assert set(finished.journals) == {*SERVICES, OBSERVER}
    told = parse_journal(finished.journals["planner"], "planner")
    assert [r.topic for r in told.records if r.kind == "event"].count("planner/event") > 10


def test_what_the_observer_saw_is_in_its_journal(tmp_path: Path) -> None:
    with made_up_cell(tmp_path) as cell:
        finished, _ = run(cell, tmp_path)
    (tmp_path / "read").write_bytes(finished.journals[OBSERVER])
    read = read_observed(tmp_path / "read")
    assert [type(s) for s in read.log] == [type(s) for s in finished.observed.log]
    assert read.events == finished.observed.events
    assert read.frames.keys() == finished.observed.frames.keys()


def test_a_second_episode_in_the_same_cell_has_its_own_journals(tmp_path: Path) -> None:
    with made_up_cell(tmp_path) as cell:
        live = Live(LiveCell("made-up", (), cell.operator, {}, None, tmp_path))
        first, second = (live.run(INSTRUCT, SCENE, lambda event: None) for _ in range(2))
    kinds = [
        [(r.kind, r.topic) for r in parse_journal(f.journals["planner"], "planner").records]
        for f in (first, second)
    ]
    assert kinds[0] == kinds[1]
    assert len(second.observed.events) == len(first.observed.events)


@pytest.mark.parametrize("service", ["perception", "belief", "planner", "executor"])
def test_a_service_that_dies_ends_the_episode_with_its_name(service: str, tmp_path: Path) -> None:
    go_on = threading.Event()
    holder = Holder(go_on)
    with made_up_cell(tmp_path, holder) as cell:

        def kill() -> None:
            assert holder.reached.wait(5)
            cell.kill(service)

        killer = threading.Thread(target=kill)
        killer.start()
        finished, _ = run(cell, tmp_path)
        go_on.set()
        killer.join()
    ended = finished.ended
    assert ended.outcome == "aborted"
    assert ended.because.startswith(f"{service} died in mid-episode")
    assert cell.executor.stops == (0 if service == "executor" else 1)
    assert len(ended.steps) == 1 and ended.steps[0].belief == made_up_episode.BELIEFS[0]
    assert service in finished.journals


def test_ctrl_c_stops_all_motion_and_cancels(tmp_path: Path) -> None:
    go_on = threading.Event()
    holder = Holder(go_on)
    with made_up_cell(tmp_path, holder) as cell:

        def interrupt() -> None:
            assert holder.reached.wait(5)
            os.kill(os.getpid(), signal.SIGINT)
            assert cell.planner.cancelled.wait(5)
            go_on.set()

        user = threading.Thread(target=interrupt)
        user.start()
        finished, _ = run(cell, tmp_path)
        user.join()
    assert finished.ended.outcome == "stopped"
    assert cell.executor.stops == 1


def test_a_planner_that_falls_silent_is_given_up(tmp_path: Path) -> None:
    go_on = threading.Event()
    with made_up_cell(tmp_path, Holder(go_on)) as cell:
        finished, _ = run(cell, tmp_path, silence_s=0.3)
        go_on.set()
    assert finished.ended.outcome == "aborted"
    assert finished.ended.reason == "planner_silent"
    assert cell.executor.stops == 1


def test_a_sentence_that_is_not_understood_moves_nothing(tmp_path: Path) -> None:
    with made_up_cell(tmp_path) as cell:
        live = Live(LiveCell("made-up", (), cell.operator, {}, None, tmp_path))
        asked = Instruct(sentence="the unicorn", profile="extended", policy="ours")
        with pytest.raises(Refused, match="unicorn") as refused:
            live.run(asked, SCENE, lambda event: None)
    assert refused.value.exit_code == 2
