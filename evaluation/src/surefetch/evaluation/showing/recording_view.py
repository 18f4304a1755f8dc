"""An episode as a Rerun recording: what the camera saw, where the arm was, what was believed.

The same writer serves a finished run (`write`) and a running one (`EpisodeView.add`). Timelines:
`step`, the planner's step; `time`, seconds in which motions last as long as the arm takes.
"""

from pathlib import Path
from typing import Any, Final

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from surefetch.common.geometry import Array, deproject, transform
from surefetch.common.mask import decode
from surefetch.common.messages import (
    Accepted,
    Acted,
    Acting,
    Believed,
    Box3d,
    Captured,
    ContainerReading,
    Decided,
    Ended,
    Event,
    Frame,
    FrameId,
    Happening,
    Motion,
    Observations,
    Perceived,
)
from surefetch.evaluation.showing import arm_view, pictures, words
from surefetch.evaluation.showing.observed import Observed, Seen
from surefetch.evaluation.showing.progress import bar

APPLICATION: Final = "surefetch"
CAMERA: Final = "world/camera"
POINT_STRIDE_PX: Final = 3
CONTAINER_CLASS: Final = 250
CONTAINER_COLOR: Final = (130, 130, 130)
MASK_OPACITY: Final = 0.45


def write(observed: Observed, path: Path) -> None:
    """Write the recording of a finished episode."""
    recording = rr.RecordingStream(APPLICATION, recording_id=_recording_id(observed))
    recording.save(path, default_blueprint=blueprint())
    view = EpisodeView(recording)
    for message in observed.log:
        view.add(message, observed.frames)
    recording.flush()
    recording.disconnect()


def _recording_id(observed: Observed) -> str:
    return observed.events[0].episode if observed.events else "no episode"


def blueprint() -> rrb.Blueprint:
    """The layout: the cell in 3-D, the camera, the belief over time, the words."""
    cell = rrb.Spatial3DView(
        origin="world",
        name="cell",
        contents=["+ $origin/**", f"- /{CAMERA}/depth", f"- /{CAMERA}/masks", f"- /{CAMERA}/boxes"],
        background=(24, 27, 32),
    )
    camera = rrb.Spatial2DView(
        origin=CAMERA, name="camera", contents=["+ $origin/**", "- $origin/depth"]
    )
    depth = rrb.Spatial2DView(origin=CAMERA, name="depth", contents=["$origin/depth"])
    belief = rrb.TimeSeriesView(
        origin="belief", name="belief", axis_y=rrb.ScalarAxis(range=(0.0, 1.0))
    )
    decision = rrb.TextDocumentView(origin="decision", name="decision")
    actions = rrb.TextLogView(origin="actions", name="actions")
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(cell, rrb.Horizontal(belief, actions), row_shares=[2, 1]),
            rrb.Vertical(rrb.Tabs(camera, depth), decision, row_shares=[1, 1]),
            column_shares=[3, 2],
        ),
        rrb.TimePanel(timeline="time", state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )


class EpisodeView:
    """Writes what an observer sees into a recording, in order of arrival."""

    def __init__(self, recording: rr.RecordingStream) -> None:
        self._to = recording
        self._time_s = 0.0
        self._step = 0
        self._shown: FrameId | None = None
        self._seen: Observations | None = None
        self._hypotheses: set[str] = set()
        self._understood = ""
        self._belief: Believed | None = None
        recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        recording.log("/", _classes(), static=True)
        arm_view.log_envelopes(recording)

    def add(self, message: Seen, frames: Any) -> None:
        """Write one message; `frames` maps frame ids to the frames fetched so far."""
        self._stamp()
        match message:
            case Event() as event:
                self._step = event.step
                self._stamp()
                self._event(event.happening, frames)
            case Observations() as seen:
                self._seen = seen
            case Motion() as motion:
                self._motion(motion)

    def _stamp(self) -> None:
        self._to.set_time("step", sequence=self._step)
        self._to.set_time("time", duration=self._time_s)

    def _pass(self, seconds: float) -> None:
        self._time_s += max(0.0, seconds)
        self._stamp()

    def _event(self, happening: Happening, frames: Any) -> None:
        match happening:
            case Accepted():
                self._understood = happening.understood
                self._say("INFO", f"understood: {happening.understood}")
            case Captured():
                self._frame(frames.get(happening.frame))
            case Perceived():
                self._pass(happening.duration_s)
                self._perceived()
            case Believed():
                self._believed(happening)
            case Decided():
                self._pass(happening.duration_s)
                self._say("INFO", f"{words.choice(happening.choice)}: {happening.because}")
                self._page(happening)
            case Acting():
                self._say("INFO", f"{words.verb(happening.verb)} …")
            case Acted():
                level = "INFO" if happening.status == "done" else "WARN"
                self._say(level, f"{happening.action} {happening.status}. {happening.why}")
            case Ended():
                self._say("INFO", f"{happening.outcome}: {happening.because}")

    def _say(self, level: str, text: str) -> None:
        self._to.log("actions", rr.TextLog(text.strip(), level=level))

    def _frame(self, frame: Frame | None) -> None:
        if frame is None or frame.info.frame == self._shown:
            return
        self._shown = frame.info.frame
        info, T = frame.info, frame.info.T_world_camera
        self._to.log(CAMERA, rr.Transform3D(translation=T[:3, 3], mat3x3=T[:3, :3]))
        self._to.log(
            CAMERA,
            rr.Pinhole(
                image_from_camera=info.K,
                width=info.width,
                height=info.height,
                camera_xyz=rr.ViewCoordinates.RDF,
                image_plane_distance=0.12,
            ),
        )
        self._to.log(f"{CAMERA}/image", rr.Image(frame.rgb).compress(jpeg_quality=92))
        millimetres = np.rint(np.clip(frame.depth_m, 0, 65) * 1000).astype(np.uint16)
        self._to.log(f"{CAMERA}/depth", rr.DepthImage(millimetres, meter=1000.0))
        points_m, colors = cloud(frame)
        self._to.log("world/points", rr.Points3D(points_m, colors=colors, radii=0.0012))
        arm_view.log_joints(self._to, np.asarray(frame.q_rad), frame.gripper_width_m)

    def _perceived(self) -> None:
        seen = self._seen
        if seen is None or seen.frame != self._shown:
            return
        self._to.log("world/container", _container(seen.container))
        boxes = [_upright(box) for box in seen.obstacles]
        self._to.log("world/obstacles", _boxes(boxes, (150, 110, 90), ["obstacle"] * len(boxes)))

    def _believed(self, believed: Believed) -> None:
        self._belief = believed
        for name, share in believed.belief.items():
            path = f"belief/{words.hypothesis(name).replace(' ', '_')}"
            if name not in self._hypotheses:
                self._hypotheses.add(name)
                self._to.log(
                    path, rr.SeriesLines(names=words.hypothesis(name), widths=2.0), static=True
                )
            self._to.log(path, rr.Scalars(share))
        self._to.log("gamma", rr.TextDocument(", ".join(map(words.hypothesis, believed.gamma))))
        self._detections(believed)

    def _detections(self, believed: Believed) -> None:
        """Masks and boxes in the image, bodies in the cell, each in the colour of its track."""
        seen = self._seen
        if seen is None or seen.frame != self._shown:
            return
        answers = dict(counted.split(" ", 1) for counted in believed.counted)
        masks = None if seen.container is None else _class_image(seen.container)
        rows = []
        for detection in seen.detections:
            track = pictures.track_of(detection, believed.tracks)
            if track is None or not detection.representative:
                continue
            bits = decode(detection.mask)
            masks = np.zeros(bits.shape, np.uint8) if masks is None else masks
            masks[bits] = track.id % CONTAINER_CLASS
            label = f"T{track.id} {answers.get(str(track.id), '')}".strip()
            rows.append((detection, pictures.track_color(track.id), label))
        if masks is not None:
            self._to.log(f"{CAMERA}/masks", rr.SegmentationImage(masks, opacity=MASK_OPACITY))
        self._to.log(
            f"{CAMERA}/boxes",
            rr.Boxes2D(
                array=np.array([row[0].box_px for row in rows]).reshape(-1, 4),
                array_format=rr.Box2DFormat.XYXY,
                labels=[row[2] for row in rows],
                colors=[row[1] for row in rows],
            ),
        )
        solids = [(d.solid, color, label) for d, color, label in rows if d.solid is not None]
        self._to.log(
            "world/objects",
            _boxes(
                [_upright(s) for s, _, _ in solids],
                [c for _, c, _ in solids],
                [t for *_, t in solids],
            ),
        )

    def _page(self, decided: Decided) -> None:
        """The decision as a page: the belief as bars, the set, the costs, the reason."""
        believed = self._belief
        lines = [f"# {self._understood}", f"**step {self._step}**", ""]
        if believed is not None:
            lines += ["| hypothesis | belief | | Γ |", "|---|---|---|---|"]
            for name, share in words.ranked(believed.belief)[:8]:
                mark = "∈ Γ" if name in believed.gamma else ""
                lines.append(
                    f"| {words.hypothesis(name)} | {share:.3f} | {bar(share, 16)} | {mark} |"
                )
        lines += ["", f"**→ {words.choice(decided.choice)}**", "", decided.because, ""]
        lines += [f"- {words.q_value(value)}" for value in decided.q_values]
        text = rr.TextDocument("\n".join(lines), media_type=rr.MediaType.MARKDOWN)
        self._to.log("decision", text)

    def _motion(self, motion: Motion) -> None:
        began_s = self._time_s
        for i in arm_view.samples(motion):
            self._time_s = began_s + float(motion.times_s[i])
            self._stamp()
            arm_view.log_joints(self._to, motion.q_rad[i], float(motion.gripper_width_m[i]))


def cloud(frame: Frame) -> tuple[Array, Any]:
    """Thinned points (n, 3) in the world frame and their colours (n, 3)."""
    stride = POINT_STRIDE_PX
    depth_m = frame.depth_m[::stride, ::stride].astype(np.float64)
    rows, columns = np.nonzero(depth_m > 0)
    pixels = np.column_stack([columns, rows]).astype(np.float64) * stride
    points_m = deproject(frame.info.K, pixels, depth_m[rows, columns])
    colors = frame.rgb[::stride, ::stride][rows, columns]
    return transform(frame.info.T_world_camera, points_m), colors


def _classes() -> rr.AnnotationContext:
    tracks = [
        rr.AnnotationInfo(id=i, label=f"T{i}", color=pictures.track_color(i)) for i in range(1, 100)
    ]
    container = rr.AnnotationInfo(id=CONTAINER_CLASS, label="container", color=CONTAINER_COLOR)
    nothing = rr.AnnotationInfo(id=0, color=(0, 0, 0, 0))
    return rr.AnnotationContext([nothing, *tracks, container])


def _class_image(container: ContainerReading) -> Any:
    return decode(container.mask).astype(np.uint8) * CONTAINER_CLASS


def _container(container: ContainerReading | None) -> rr.Boxes3D:
    if container is None:
        return _boxes([], CONTAINER_COLOR, [])
    parts = [_upright(container.outer)]
    labels = ["container" if container.complete else "container (cut)"]
    if container.lid is not None:
        parts.append(_upright(container.lid.plate))
        labels.append("cover")
    return _boxes(parts, CONTAINER_COLOR, labels)


def _upright(box: Box3d) -> tuple[Any, Any, Any]:
    half = box.yaw_rad / 2
    return box.center_world_m, box.size_m, (0.0, 0.0, np.sin(half), np.cos(half))


def _boxes(boxes: list[tuple[Any, Any, Any]], colors: Any, labels: list[str]) -> rr.Boxes3D:
    return rr.Boxes3D(
        centers=[center for center, _, _ in boxes],
        sizes=[size for _, size, _ in boxes],
        quaternions=[quaternion for *_, quaternion in boxes],
        colors=colors,
        labels=labels,
    )
