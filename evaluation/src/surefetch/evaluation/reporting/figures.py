"""The report's diagrams, as SVG. Pure but for what matplotlib keeps to itself."""

import io
from collections.abc import Mapping, Sequence
from typing import Any, Final

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from surefetch.evaluation.reporting.commitment import Point
from surefetch.evaluation.reporting.coverage import Coverage
from surefetch.evaluation.reporting.reliability import Reliability
from surefetch.evaluation.running.metrics import wilson
from surefetch.evaluation.showing.pictures import PALETTE
from surefetch.evaluation.showing.trace_figure import FAINT, INK, STYLE

COLORS: Final = ["#" + "".join(f"{part:02x}" for part in rgb) for rgb in PALETTE]
CLASS_COLORS: Final = (
    "#0a7d55", "#e69f00", "#c0392b", "#8e6bb0", "#56b4e9", "#7f8c8d", "#b7b7b7", "#cc79a7",
    "#444444", "#222222",
)  # fmt: skip
MARKERS: Final = ("o", "s", "^", "D", "v", "P", "X")
SAME: Final = {"svg.hashsalt": "surefetch", "svg.fonttype": "path"}
"""The same figure is the same file."""

Curve = tuple[Sequence[Point], tuple[float, float] | None]


def risk_coverage(curves: Mapping[str, Curve]) -> bytes:
    """Risk over coverage; a dot where the policy stands."""
    with matplotlib.rc_context(STYLE | SAME):
        figure = Figure(figsize=(6.4, 4.2))
        axes = figure.add_subplot()
        for color, (name, (points, now)) in zip(_colors(len(curves)), curves.items(), strict=True):
            x, y = [p.coverage for p in points], [p.risk for p in points]
            axes.step(x, y, where="post", label=name, color=color, linewidth=1.6)
            if now is not None:
                axes.plot(*now, "o", color=color, markersize=6)
        axes.set_xlabel("coverage: share of present targets grasped for")
        axes.set_ylabel("risk: share of grasps at another object")
        axes.set_xlim(0.0, 1.02)
        axes.set_ylim(bottom=0.0)
        return _svg(figure, legend=True)


def coverage(levels: Mapping[str, Sequence[Coverage]]) -> bytes:
    """Empirical coverage over 1 − α, with Wilson bars and the band of the calibration draw."""
    with matplotlib.rc_context(STYLE | SAME):
        figure = Figure(figsize=(5.6, 4.6))
        axes = figure.add_subplot()
        axes.plot([0.0, 1.0], [0.0, 1.0], color=FAINT, linewidth=0.8)
        for color, (name, found) in zip(_colors(len(levels)), levels.items(), strict=True):
            x = [1 - float(one.alpha) for one in found]
            y = np.array([one.share for one in found])
            bars = np.abs(np.array([one.interval for one in found]).T - y)
            axes.errorbar(x, y, bars, fmt="o", markersize=3.5, capsize=2, color=color, label=name)
            if len(found) > 1:
                low, high = zip(*(one.band for one in found), strict=True)
                axes.fill_between(x, low, high, color=color, alpha=0.15, linewidth=0)
        axes.set_xlim(0.45, 1.0)
        axes.set_ylim(0.4, 1.01)
        axes.set_xlabel("promised: 1 − α")
        axes.set_ylabel("episodes with z* in Γ at every step")
        return _svg(figure, legend=True)


def reliability(found: Mapping[str, Reliability]) -> bytes:
    """How often the heaviest hypothesis is true, over its mass."""
    with matplotlib.rc_context(STYLE | SAME):
        figure = Figure(figsize=(5.0, 4.6))
        axes = figure.add_subplot()
        axes.plot([0.0, 1.0], [0.0, 1.0], color=FAINT, linewidth=0.8)
        for color, (name, one) in zip(_colors(len(found)), found.items(), strict=True):
            x, y = [b.belief for b in one.bins], np.array([b.right for b in one.bins])
            ends = np.array([wilson(round(b.right * b.n), b.n) for b in one.bins]).T
            bars = np.maximum(0.0, np.abs(ends - y))
            axes.errorbar(x, y, bars, fmt="o-", markersize=4, capsize=2, color=color, label=name)
        axes.set_xlim(0.0, 1.02)
        axes.set_ylim(0.0, 1.02)
        axes.set_xlabel("mass of the heaviest hypothesis")
        axes.set_ylabel("how often it is the truth")
        return _svg(figure, legend=True)


def cost_success(methods: Mapping[str, tuple[float, int, int]]) -> bytes:
    """Success over mean action cost; of each method cost, successes and episodes."""
    with matplotlib.rc_context(STYLE | SAME):
        figure = Figure(figsize=(8.4, 5.2))
        axes = figure.add_subplot()
        for n, (name, (cost, k, of)) in enumerate(methods.items()):
            low, high = wilson(k, of)
            bars = [[k / of - low], [high - k / of]]
            color, marker = COLORS[n % len(COLORS)], MARKERS[n // len(COLORS) % len(MARKERS)]
            axes.errorbar(
                [cost], [k / of], bars, capsize=2, linestyle="", label=name, color=color,
                marker=marker,
            )  # fmt: skip
        axes.set_xlabel("mean action cost")
        axes.set_ylabel("success, with Wilson's 95 %")
        axes.set_ylim(0.0, 1.03)
        return _svg(figure, legend=True)


def classes(counts: Mapping[str, Mapping[str, int]]) -> bytes:
    """How episodes ended, stacked, one bar a method."""
    with matplotlib.rc_context(STYLE | SAME):
        figure = Figure(figsize=(8.4, 0.9 + 0.27 * len(counts)))
        axes = figure.add_subplot()
        names = list(counts)
        left = np.zeros(len(names))
        verdicts = list(next(iter(counts.values()), {}))
        for color, verdict in zip(CLASS_COLORS, verdicts, strict=False):
            width = np.array([counts[name][verdict] for name in names], float)
            if width.any():
                told = verdict.replace("_", " ")
                axes.barh(range(len(names)), width, left=left, color=color, label=told)
            left += width
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.set_xlabel("episodes")
        return _svg(figure, legend=True)


def strata(found: Mapping[str, Sequence[tuple[str, int, int]]]) -> bytes:
    """Success by occlusion; of each method stratum, successes and episodes."""
    with matplotlib.rc_context(STYLE | SAME):
        figure = Figure(figsize=(7.4, 4.0))
        axes = figure.add_subplot()
        names = list(dict.fromkeys(s for of in found.values() for s, _, _ in of))
        for n, (color, (method, of)) in enumerate(
            zip(_colors(len(found)), found.items(), strict=True)
        ):
            x = np.array([names.index(s) for s, _, _ in of]) + 0.12 * (n - (len(found) - 1) / 2)
            y = np.array([k / total for _, k, total in of])
            bars = np.abs(np.array([wilson(k, total) for _, k, total in of]).T - y)
            axes.errorbar(x, y, bars, fmt="o", capsize=2, color=color, label=method)
        totals = {s: total for of in found.values() for s, _, total in of}
        axes.set_xticks(range(len(names)), [f"{name}\nn = {totals[name]}" for name in names])
        axes.set_ylim(0.0, 1.03)
        axes.set_ylabel("success, with Wilson's 95 %")
        axes.set_xlabel("share of the target that the first look does not show")
        return _svg(figure, legend=True)


def discordances(names: Sequence[str], psi: np.ndarray[Any, np.dtype[np.float64]]) -> bytes:
    """ψ of every pair of methods: the share of scenes on which one of the two succeeds."""
    with matplotlib.rc_context(STYLE | SAME):
        side = 2.4 + 0.33 * len(names)
        figure = Figure(figsize=(side + 0.6, side))
        axes = figure.add_subplot()
        axes.imshow(psi, cmap="Blues", vmin=0.0, vmax=max(0.01, float(psi.max())))
        for i, row in enumerate(psi):
            for j, value in enumerate(row):
                dark = value > 0.6 * psi.max()
                axes.text(
                    j, i, f"{100 * value:.0f}", ha="center", va="center", fontsize=7,
                    color="white" if dark else INK,
                )  # fmt: skip
        axes.set_xticks(range(len(names)), names, rotation=90, fontsize=7)
        axes.set_yticks(range(len(names)), names, fontsize=7)
        return _svg(figure, legend=False)


def _colors(n: int) -> list[str]:
    return [COLORS[k % len(COLORS)] for k in range(n)]


def _svg(figure: Figure, *, legend: bool) -> bytes:
    axes = figure.axes[0]
    if legend and axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, fontsize=7.5, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    file = io.BytesIO()
    figure.savefig(file, format="svg", bbox_inches="tight", metadata={"Date": None})
    return file.getvalue()
