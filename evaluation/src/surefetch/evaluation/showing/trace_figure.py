"""The trace of one episode as a picture: the views, the belief after each, and what was done.

Belief is grouped as in the paper's trace: the followed track inside and outside, all other
hypotheses of a present target (the not yet seen among them), and absence.
"""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from surefetch.common.hypotheses import ABS, RELATIONS, parse_tracked, tracked
from surefetch.common.mask import decode
from surefetch.common.messages import Believed, Choice, Decided, Defer, Grasp, Inform
from surefetch.evaluation.showing import pictures, words
from surefetch.evaluation.showing.observed import Observed, Step, steps

COLUMN_IN: Final = 3.3
DPI: Final = 130
INK: Final = "#1b1f24"
FAINT: Final = "#6b7280"
GROUP_COLORS: Final = ("#0072b2", "#56b4e9", "#9aa3ad", "#d55e00")
TAGS: Final = {"mismatch": "≠"}
LEGEND: Final = (
    "MI, MO, MU: fits the words, and is inside, outside, unclear where.   UI, UO, UU: likewise, "
    "but whether it fits cannot be read.   ≠: does not fit.   Γ: the hypotheses that remain."
)
TAG_HEIGHT_PX: Final = 30.0
TAG_LETTER_PX: Final = 12.5
"""Room for a tag, in pixels of a 640 pixel wide image."""
GOOD: Final = "#117a52"
BAD: Final = "#a33b20"
STYLE: Final[Any] = {
    "font.size": 9,
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": FAINT,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def draw(observed: Observed, path: Path) -> None:
    """Write the trace of an episode as a PNG. An episode without a look leaves an empty trace."""
    looks = list(steps(observed.events))
    columns = max(1, len(looks))
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(max(7.0, COLUMN_IN * columns), 6.4), dpi=DPI, facecolor="white")
        grid = figure.add_gridspec(
            3,
            columns,
            height_ratios=(2.5, 1.9, 1.1),
            left=0.55 / figure.get_figwidth(),
            right=1 - 0.15 / figure.get_figwidth(),
            top=0.85,
            bottom=0.05,
            hspace=0.22,
            wspace=0.08,
        )
        _title(figure, observed)
        track = followed_track(observed)
        for column, look in enumerate(looks):
            _view(figure.add_subplot(grid[0, column]), observed, look, column)
            if look.believed is None:
                _afterwards(figure.add_subplot(grid[1, column]), observed, look)
                continue
            _bars(figure.add_subplot(grid[1, column]), look.believed, track, first=column == 0)
            _action(figure.add_subplot(grid[2, column]), look)
        figure.text(0.2 / figure.get_figwidth(), 0.012, LEGEND, fontsize=7, color=FAINT)
        figure.savefig(path)


def followed_track(observed: Observed) -> int | None:
    """The track that was grasped, else the most probable one at the end."""
    ended = observed.ended
    if ended is not None and ended.track is not None:
        return ended.track
    beliefs = [e.happening.belief for e in observed.events if isinstance(e.happening, Believed)]
    for name, _ in words.ranked(beliefs[-1]) if beliefs else ():
        parsed = parse_tracked(name)
        if parsed is not None:
            return parsed[0]
    return None


def grouped(belief: dict[str, float], track: int | None) -> tuple[float, float, float, float]:
    """Followed track inside, outside, all other hypotheses of presence, absence."""
    if track is None:
        own = [0.0, 0.0]
    else:
        own = [belief.get(tracked(track, relation), 0.0) for relation in RELATIONS]
    absent = belief.get(ABS, 0.0)
    return own[0], own[1], max(0.0, sum(belief.values()) - sum(own) - absent), absent


def eligible(decided: Decided) -> bool:
    """Whether some grasp passed both the conformal rule and the robot's checks."""
    return any(value.action == "grasp" for value in decided.q_values)


def _title(figure: Figure, observed: Observed) -> None:
    accepted, ended = observed.accepted, observed.ended
    left = 0.2 / figure.get_figwidth()
    asked = accepted.understood if accepted else "no instruction was accepted"
    figure.text(left, 0.955, asked, fontsize=14, fontweight="bold", va="center")
    if ended is None:
        figure.text(left, 0.912, "the episode did not end", fontsize=10, color=BAD, va="center")
        return
    grasped = "" if ended.track is None else f" T{ended.track} {ended.relation}"
    color = {"grasped": GOOD, "deferred": "#8a6100"}.get(ended.outcome, BAD)
    text = f"{ended.outcome}{grasped}"
    because = textwrap.shorten(ended.because, round(16 * figure.get_figwidth()), placeholder=" …")
    figure.text(left, 0.912, text, fontsize=11, fontweight="bold", color=color, va="center")
    offset = (0.45 + 0.092 * len(text)) / figure.get_figwidth()
    figure.text(offset, 0.912, because, fontsize=9, color=FAINT, va="center")


def _view(axes: Any, observed: Observed, look: Step, column: int) -> None:
    """The image with masks and, at each, its track and answer."""
    axes.set_axis_off()
    condition = look.q.replace("_", " ") if look.believed else "to verify"
    axes.set_title(f"({chr(97 + column % 26)})  {condition}", fontsize=10, loc="left")
    frame = observed.frames.get(look.captured.frame)
    if frame is None:
        axes.text(0.5, 0.5, "no frame", ha="center", transform=axes.transAxes, color=FAINT)
        return
    seen = observed.observations.get(look.captured.frame)
    image = frame.rgb.copy()
    tags = []
    tracks = look.believed.tracks if look.believed else ()
    answers = dict(c.split(" ", 1) for c in look.believed.counted) if look.believed else {}
    if seen is not None and seen.container is not None:
        image = pictures.paint(image, decode(seen.container.mask), (120, 120, 120), 0.0)
    for detection in seen.detections if seen is not None else ():
        track = pictures.track_of(detection, tracks)
        if not detection.representative or track is None:
            continue
        color = pictures.track_color(track.id)
        image = pictures.paint(image, decode(detection.mask), color, 0.35)
        answer = answers.get(str(track.id), "")
        text = f"T{track.id} {TAGS.get(answer, answer)}".strip()
        x0, y0, x1, _ = detection.box_px
        tags.append(Tag((x0 + x1) / 2, y0 - 6, text, color))
    axes.imshow(image, interpolation="antialiased")
    for tag in apart(tags, frame.info.width / 640):
        _draw_tag(axes, tag)


@dataclass(frozen=True)
class Tag:
    """A word on an image: the middle of its lower edge, in pixels."""

    x_px: float
    y_px: float
    text: str
    color: pictures.Rgb8


def apart(tags: Sequence[Tag], scale: float) -> list[Tag]:
    """The tags, moved upwards until none covers another one or leaves the image at the top.

    Args:
        tags: where they would stand by themselves.
        scale: image width over 640 pixels.
    """
    placed: list[Tag] = []
    for tag in sorted(tags, key=lambda tag: -tag.y_px):
        y_px = max(tag.y_px, TAG_HEIGHT_PX * scale)
        while any(_cover(replace(tag, y_px=y_px), other, scale) for other in placed):
            y_px -= 2.0 * scale
        placed.append(replace(tag, y_px=y_px))
    return placed


def _cover(a: Tag, b: Tag, scale: float) -> bool:
    room_px = (len(a.text) + len(b.text) + 1) / 2 * TAG_LETTER_PX * scale
    return abs(a.x_px - b.x_px) < room_px and abs(a.y_px - b.y_px) < TAG_HEIGHT_PX * scale


def _draw_tag(axes: Any, tag: Tag) -> None:
    rgb = np.asarray(tag.color) / 255.0
    dark = float(rgb @ np.array([0.299, 0.587, 0.114])) < 0.55
    axes.text(
        tag.x_px,
        tag.y_px,
        tag.text,
        fontsize=7.5,
        fontweight="bold",
        ha="center",
        va="bottom",
        color="white" if dark else INK,
        bbox={"boxstyle": "round,pad=0.2", "facecolor": rgb, "edgecolor": "none"},
    )


def _afterwards(axes: Any, observed: Observed, look: Step) -> None:
    """What followed a look that only verified: the commands after it, and the end."""
    axes.set_axis_off()
    ended = observed.ended
    lines = [f"{acted.action.replace('_', ' ')} {acted.status}" for acted in look.acted]
    if ended is not None and ended.outcome == "grasped":
        lines = ["lift verified", *lines]
    for row, text in enumerate(lines):
        axes.text(
            0.5,
            0.85 - 0.2 * row,
            text,
            ha="center",
            fontsize=10,
            transform=axes.transAxes,
            color=GOOD if ended is not None and ended.outcome == "grasped" else INK,
        )


def _bars(axes: Any, believed: Believed | None, track: int | None, *, first: bool) -> None:
    axes.set_ylim(0.0, 1.12)
    axes.set_yticks([0.0, 0.5, 1.0])
    axes.tick_params(axis="x", length=0)
    axes.grid(axis="y", color="#e5e7eb", linewidth=0.8)
    axes.set_axisbelow(True)
    if first:
        axes.set_ylabel("belief")
    else:
        axes.set_yticklabels([])
    if believed is None:
        axes.set_xticks([])
        return
    own = "track" if track is None else f"T{track}"
    shares = grouped(believed.belief, track)
    bars = axes.bar(range(4), shares, width=0.68, color=GROUP_COLORS)
    for bar, share in zip(bars, shares, strict=True):
        at = bar.get_x() + bar.get_width() / 2
        axes.text(at, share + 0.03, f"{share:.3f}", ha="center", fontsize=8)
    axes.set_xticks(
        range(4), [f"{own}\ninside", f"{own}\noutside", "other\nhypotheses", "absent"], fontsize=8
    )


def _action(axes: Any, look: Step) -> None:
    axes.set_axis_off()
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    if look.decided is None:
        return
    chosen = words.choice(look.decided.choice).replace("_", " ")
    axes.text(
        0.5,
        0.70,
        f"→  {chosen}" + _results(look),
        ha="center",
        va="center",
        fontsize=10,
        fontweight="bold",
        bbox={
            "boxstyle": "round,pad=0.45",
            "facecolor": _face(look.decided.choice),
            "edgecolor": "none",
        },
    )
    able = eligible(look.decided)
    flag = "grasp eligible" if able else "no grasp eligible"
    axes.text(0.5, 0.34, flag, ha="center", fontsize=8.5, color=GOOD if able else FAINT)
    members = look.believed.gamma if look.believed else ()
    gamma = textwrap.shorten(", ".join(map(words.hypothesis, members)) or "nothing", 46)
    axes.text(0.5, 0.10, f"Γ = {{{gamma}}}", ha="center", fontsize=7.5, color=FAINT)


def _face(chosen: Choice | None) -> str:
    match chosen:
        case Grasp():
            return "#d9f0e5"
        case Defer():
            return "#fdf0cf"
        case Inform():
            return "#dfeaf5"
    return "#eeeeee"


def _results(look: Step) -> str:
    failed = [acted for acted in look.acted if acted.status != "done"]
    return f"  ({failed[0].status})" if failed else ""
