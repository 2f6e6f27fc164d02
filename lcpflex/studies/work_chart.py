"""The picture of a work-precision study."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from lcpflex.studies.work_points import SceneStudy, WorkPoint, WorkPrecision

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["chart"]

# Okabe and Ito's colours, told apart with any colour vision; markers say the same without colours.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#7B3294")
MARKERS = "osD^vPX*"
LIMIT = "#D9D9D9"
FRONT = "#FFE680"
WIDTH = 34  # characters of a line of the legend


def chart(work: WorkPrecision, output: str | None) -> Figure:
    """A row a scene: error against wall time, error against steps, and who is who."""
    from matplotlib.figure import Figure

    count = len(work.studies)
    figure = Figure(figsize=(13.0, 0.2 + 4.0 * count), layout="constrained")
    rows = figure.subplots(count, 3, squeeze=False, width_ratios=(1.0, 1.0, 0.62))
    methods = tuple(dict.fromkeys(label for study in work.studies for label in study.methods))
    looks = {
        label: {"color": COLOURS[k % len(COLOURS)], "marker": MARKERS[k % len(MARKERS)]}
        for k, label in enumerate(methods)
    }
    for study, axes in zip(work.studies, rows, strict=True):
        name = study.output(output)
        bottom, top = _range(study, name)
        for ax, abscissa in zip(axes, (_milliseconds, _steps), strict=False):
            _panel(ax, study, name, looks, abscissa, (bottom, top))
        axes[0].set(xlabel="wall time [ms]", ylabel=f"error of {name}, relative")
        axes[1].set(xlabel="steps")
        axes[0].set_title(f"{study.scene}: {name}", fontsize="medium", loc="left")
        axes[1].tick_params(labelleft=False)
        axes[2].set_axis_off()
        _legend(axes[2], study, looks, name)
    return figure


def _milliseconds(point: WorkPoint) -> float:
    return 1e3 * point.wall_time


def _steps(point: WorkPoint) -> float:
    return float(point.steps) if point.steps else math.nan


def _range(study: SceneStudy, output: str) -> tuple[float, float]:
    """Lowest and highest error shown: whole decades about the finite ones and that of the reference."""
    own = study.reference.error[output]
    values = [point.errors[output] for point in study.points if output in point.errors and not point.failure]
    known = [min(value, 10.0) for value in (*values, own) if 0.0 < value < math.inf]
    if not known:
        return 1e-6, 1.0
    low = max(min(known), 1e-12)
    if 0.0 < own < math.inf:
        low = max(low, 0.1 * own)
    return 10.0 ** math.floor(math.log10(low)), 10.0 ** math.ceil(math.log10(1.01 * max(known)))


def _panel(ax: Axes, study: SceneStudy, output: str, looks: Any, abscissa: Any, limits: tuple[float, float]) -> None:
    bottom, top = limits
    failures = top * (top / bottom) ** 0.06  # where the crosses are
    ceiling = top * (top / bottom) ** 0.12
    ax.set(xscale="log", yscale="log", ylim=(bottom, ceiling))
    own = study.reference.error[output]
    if own > bottom:
        ax.axhspan(bottom, own, color=LIMIT, zorder=0.5, linewidth=0.0)
    ax.axhline(top, color="#999999", linewidth=0.8, zorder=1.0)
    sound = [p for p in study.points if _is_sound(p, output) and math.isfinite(abscissa(p))]
    front = _front([(abscissa(p), max(p.errors[output], _least(study, p, output, bottom))) for p in sound])
    if len(front) > 1:
        ax.plot(*zip(*front, strict=True), color=FRONT, linewidth=9.0, zorder=1.5, solid_capstyle="round")
    for label in study.methods:
        look = looks[label]
        own_points = [p for p in sound if p.method == label]
        x = [abscissa(p) for p in own_points]
        y = [min(max(p.errors[output], bottom * 1.15), top) for p in own_points]
        ax.plot(x, y, color=look["color"], linewidth=1.4, zorder=2.0)
        hollow = [study.limited(p, output) for p in own_points]
        for empty in (False, True):
            chosen = [k for k, flag in enumerate(hollow) if flag == empty]
            ax.plot(
                [x[k] for k in chosen], [y[k] for k in chosen], linestyle="none", markersize=6.5, zorder=3.0, **look,
                markerfacecolor="white" if empty else look["color"],
            )  # fmt: skip
        failed = [abscissa(p) for p in study.points if p.method == label and p.failure and not p.refused]
        failed = [cost for cost in failed if math.isfinite(cost)]
        ax.plot(
            failed, [failures] * len(failed), linestyle="none", marker="x", color=look["color"],
            markersize=7.0, markeredgewidth=1.8, zorder=3.0,
        )  # fmt: skip
    ax.grid(True, which="major", linewidth=0.4, alpha=0.6)
    ax.text(
        0.995, 0.97 * top, "above: failed ", transform=ax.get_yaxis_transform(), ha="right", va="top",
        fontsize="x-small", color="#666666",
    )  # fmt: skip


def _is_sound(point: WorkPoint, output: str) -> bool:
    return not point.failure and math.isfinite(point.errors.get(output, math.nan))


def _least(study: SceneStudy, point: WorkPoint, output: str, bottom: float) -> float:
    """The smallest error that may be claimed of a point."""
    floor = study.floor(point, output)
    return max(floor, bottom) if math.isfinite(floor) else bottom


def _front(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Those that no other one beats in cost and error, by cost."""
    front: list[tuple[float, float]] = []
    for cost, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((cost, error))
    return front


def _legend(ax: Axes, study: SceneStudy, looks: Any, output: str) -> None:
    """Beside the panels of a scene: methods, signs, reference and what does not apply."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Any] = [
        Line2D([], [], label=textwrap.fill(label, WIDTH, max_lines=3), linewidth=1.4, **looks[label])
        for label in study.methods
    ]
    handles.append(Line2D([], [], color=FRONT, linewidth=9.0, label="best of all (Pareto)"))
    if any(_is_sound(point, output) and study.limited(point, output) for point in study.points):
        handles.append(
            Line2D([], [], color="#666666", marker="o", markerfacecolor="white", linestyle="none",
                   label="hollow: error too small to tell")
        )  # fmt: skip
    if any(point.failure and not point.refused for point in study.points):
        handles.append(Line2D([], [], color="#666666", marker="x", linestyle="none", label="failed"))
    own = study.reference.error[output]
    handles.append(Patch(color=LIMIT, label=f"below the reference's error {own:.1e}" if np.isfinite(own)
                         else "error of the reference: unknown"))  # fmt: skip
    lines = [f"reference: {study.reference.source}"]
    lines += [f"{label}: does not apply" for label in study.refusals]
    title = "\n".join(textwrap.fill(line, 40, subsequent_indent="  ", max_lines=4) for line in lines)
    legend = ax.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.0, frameon=False,
        fontsize="small", title=title, title_fontsize="small", alignment="left",
    )  # fmt: skip
    legend.set_in_layout(False)  # its axes are wide enough; the panels shall not shrink for it
