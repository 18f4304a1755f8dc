"""From what was perceived to the message that says it. Pure."""

import numpy as np

from surefetch.common import mask
from surefetch.common.mask import Bits
from surefetch.common.messages import (
    Answers,
    Box3d,
    ContainerReading,
    CoverState,
    Detection,
    FrameId,
    Observations,
)
from surefetch.common.messages import Lid as LidReading
from surefetch.perception.candidate import Candidate, SceneView
from surefetch.perception.container import Container, Lid
from surefetch.perception.observe import Perceived
from surefetch.perception.rectangle import Rectangle


def reply(perceived: Perceived, frame: FrameId, backend: str, *, duration_s: float) -> Observations:
    """Everything perceived in one frame, as it travels."""
    return Observations(
        frame=frame,
        backend=backend,
        detections=detections(perceived, f"{frame.boot}/{frame.counter}"),
        container=container_reading(perceived.scene),
        cover=cover(perceived.scene),
        obstacles=perceived.obstacles.boxes,
        obstacle_points_world_m=perceived.obstacles.points_world_m,
        duration_s=duration_s,
    )


def detections(perceived: Perceived, prefix: str) -> tuple[Detection, ...]:
    """The candidates in order; ids are the prefix and the index."""
    rows = zip(perceived.scene.candidates, perceived.groups, perceived.answers, strict=True)
    return tuple(
        _detection(candidate, f"{prefix}/{i}", group, answers)
        for i, (candidate, group, answers) in enumerate(rows)
    )


def _detection(candidate: Candidate, name: str, group: int, answers: Answers | None) -> Detection:
    points = candidate.points_world_m
    return Detection(
        id=name,
        box_px=candidate.box_px,
        score=candidate.score,
        phrase=candidate.phrase,
        mask=mask.encode(candidate.bits),
        group=group,
        representative=answers is not None,
        center_world_m=candidate.center_world_m,
        solid=candidate.solid,
        points_world_m=np.zeros((0, 3), dtype=np.float32) if points is None else points,
        hist=candidate.hist,
        answers=answers,
    )


def cover(scene: SceneView) -> CoverState:
    """Covered or open as seen; unknown without a container in view."""
    return "unknown" if scene.container is None else scene.container.cover


def container_reading(scene: SceneView) -> ContainerReading | None:
    """The container as it travels; None when none is in view."""
    found = scene.container
    if found is None:
        return None
    support_z = scene.surface.support_z_m
    bits: Bits = found.mask if scene.container_bits is None else scene.container_bits
    return ContainerReading(
        box_px=mask.box_of(bits),
        score=found.score,
        mask=mask.encode(bits),
        outer=_upright(found.outer, support_z, support_z + found.rim_m),
        inner_size_m=found.inner.size_m,
        floor_z_m=support_z + found.floor_m,
        rim_z_m=support_z + found.rim_m,
        complete=found.complete,
        lid=None if found.lid is None else _lid(found, found.lid, support_z),
    )


def _lid(container: Container, lid: Lid, support_z: float) -> LidReading:
    plate = _upright(lid.plate, support_z + container.rim_m, support_z + lid.top_m)
    return LidReading(plate=plate, knob=lid.knob)


def _upright(rectangle: Rectangle, bottom_z_m: float, top_z_m: float) -> Box3d:
    x, y = rectangle.center_m
    return Box3d(
        center_world_m=(x, y, 0.5 * (bottom_z_m + top_z_m)),
        size_m=(*rectangle.size_m, top_z_m - bottom_z_m),
        yaw_rad=rectangle.yaw_rad,
    )
