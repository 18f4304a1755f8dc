"""The Rerun recording can be read back and holds the whole episode."""

from pathlib import Path

import made_up_episode
import numpy as np
import pytest
from rerun.chunk import RrdReader

from surefetch.evaluation.showing import recording_view
from surefetch.evaluation.showing.observed import Observed


def entities(path: Path) -> dict[str, set[str]]:
    """Entity paths of a recording and the timelines that each has data on."""
    found: dict[str, set[str]] = {}
    for chunk in RrdReader(path).stream():
        found.setdefault(chunk.entity_path, set()).update(chunk.timeline_names)
    return found


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> dict[str, set[str]]:
    path = tmp_path_factory.mktemp("recording") / "episode.rrd"
    recording_view.write(made_up_episode.observed(), path)
    return entities(path)


@pytest.mark.parametrize(
    "path",
    [
        "/world/camera/image",
        "/world/camera/depth",
        "/world/camera/masks",
        "/world/camera/boxes",
        "/world/points",
        "/world/objects",
        "/world/container",
        "/world/arm/wrist_3",
        "/belief/T1_outside",
        "/belief/absent",
        "/gamma",
        "/actions",
        "/decision",
    ],
)
def test_everything_is_on_both_timelines(recording: dict[str, set[str]], path: str) -> None:
    assert {"step", "time"} <= recording[path]


def test_points_are_where_the_camera_saw_them() -> None:
    frame = made_up_episode.frame(0)
    points_m, colors = recording_view.cloud(frame)
    T = frame.info.T_world_camera
    along_axis_m = (points_m - T[:3, 3]) @ T[:3, 2]
    assert along_axis_m == pytest.approx(np.full(len(points_m), 0.6), abs=1e-6)
    assert len(colors) == len(points_m)


def test_an_episode_without_frames_still_has_a_recording(tmp_path: Path) -> None:
    whole = made_up_episode.observed()
    recording_view.write(Observed(whole.log, {}), tmp_path / "episode.rrd")
    assert "/belief/absent" in entities(tmp_path / "episode.rrd")
