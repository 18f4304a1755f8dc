"""A running cell is drawn as it is seen, also by whoever joins late."""

import threading
from pathlib import Path

import made_up_episode
import rerun as rr
from made_up_cell import made_up_cell
from rerun.chunk import RrdReader

from surefetch.common.messages import Ended, Event, Instruct
from surefetch.common.topics import INSTRUCT, OBSERVED
from surefetch.evaluation.showing.live_view import LiveView

ASKED = Instruct(sentence="the red cylinder", profile="extended", policy="ours")


def watched(folder: Path, *, late: bool = False) -> tuple[list[Path], list[Event]]:
    """The recordings of one episode, and the events that were shown."""
    paths: list[Path] = []
    shown: list[Event] = []

    def begin(episode: str) -> rr.RecordingStream:
        paths.append(folder / f"{episode}.rrd")
        recording = rr.RecordingStream("surefetch", recording_id=episode)
        recording.save(paths[-1])
        return recording

    def over() -> bool:
        return bool(shown) and isinstance(shown[-1].happening, Ended)

    with made_up_cell(folder) as cell:
        view = LiveView(cell.operator, begin, shown.append)
        drawing = threading.Thread(target=lambda: view.draw_until(over))
        drawing.start()
        if late:
            cell.operator.publish(OBSERVED, made_up_episode.observations(0))
        cell.operator.ask(INSTRUCT, ASKED, timeout_s=5.0)
        drawing.join(10.0)
        assert not drawing.is_alive()
        view.close()
    return paths, shown


def test_an_episode_is_one_recording_with_its_frames(tmp_path: Path) -> None:
    (path,), shown = watched(tmp_path)
    assert len(shown) == len(made_up_episode.events())
    entities = {chunk.entity_path for chunk in RrdReader(path).stream()}
    assert {"/world/camera/image", "/world/arm/wrist_3", "/belief/absent", "/actions"} <= entities


def test_who_joins_late_sees_the_rest(tmp_path: Path) -> None:
    (path,), _ = watched(tmp_path, late=True)
    assert path.name == "joined.rrd"
