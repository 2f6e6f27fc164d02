"""The picture of a work-precision study."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lcpflex.basics import libs
from lcpflex.studies.chart_style import looks_of
from lcpflex.studies.convergence.equal_times import UNKNOWN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.studies.convergence.points import SceneStudy, WorkPoint, WorkPrecision

__all__ = ["PANELS", "chart"]

LIMIT = "#D9D9D9"
DOUBT = "#8A8A8A"
FRONT = "#FFE680"
WIDTH = 34  # characters of a line of the legend
LEAST = 1e-12  # smallest error shown
PANELS = ("error", "equal times", "steps", "claimed")


class _Measure(NamedTuple):
    """What a panel shows of the points: a value, what it may be wrong by, and how far the reference goes."""

    value: Callable[[WorkPoint], float]
    floor: Callable[[WorkPoint], float]
    recorded: Callable[[WorkPoint], bool]
    own: float
    reach: float


def chart(work: WorkPrecision, output: str | None, panels: Sequence[str] | None = None) -> Figure:
    """A row a scene: error and difference at equal times against wall time, error against steps, and who is who."""
    last = "claimed" if any(study.has_claims for study in work.studies) else "steps"
    shown = (*PANELS[:2], last) if panels is None else tuple(panels)
    count, across = len(work.studies), len(shown)
    figure = libs.Figure(figsize=(4.45 * across + 3.15, 0.2 + 4.0 * count), layout="constrained")
    rows = figure.subplots(count, across + 1, squeeze=False, width_ratios=(*[1.0] * across, 0.72))
    for study, axes in zip(work.studies, rows, strict=True):
        name = study.output(output)
        looks = looks_of({p.method: p.stepper for p in study.points if p.method in study.methods})
        for ax, panel in zip(axes, shown, strict=False):
            _DRAWN[panel](ax, study, name, looks)
        ax = axes[0]
        kind = ", shape" if study.reference.measured[name].parts and "equal times" in shown else ""
        ax.set_title(f"{study.scene}: {name}{kind}", fontsize="medium", loc="left")
        axes[-1].set_axis_off()
        _legend(axes[-1], study, looks, name, "equal times" in shown)
    return figure


def _errors(ax: Axes, study: SceneStudy, name: str, looks: Any) -> None:
    _panel(ax, study, _shape(study, name), looks, _milliseconds)
    ax.set(xlabel="wall time [ms]", ylabel=f"error of {name}, relative")


def _at_equal_times(ax: Axes, study: SceneStudy, name: str, looks: Any) -> None:
    if not study.reference.measured[name].parts:
        ax.set_axis_off()
        return
    _panel(ax, study, _timing(study, name), looks, _milliseconds)
    _bars(ax, study, name, looks)
    ax.set(xlabel="wall time [ms]", ylabel="mean difference at equal times, relative")
    ax.set_title("at equal times", fontsize="medium", loc="left")


def _against_steps(ax: Axes, study: SceneStudy, name: str, looks: Any) -> None:
    _panel(ax, study, _shape(study, name), looks, _steps)
    ax.set(xlabel="steps", ylabel=f"error of {name}, relative")


def _claims(ax: Axes, study: SceneStudy, name: str, looks: Any) -> None:
    """What runs claim against what they are off by, where that is known: above the diagonal they claim enough."""
    known = [p for p in study.points if not p.failure and name in p.claims and not study.limited(p, name)]
    pairs = [(p.errors[name], max(p.claims[name], LEAST)) for p in known]
    ends = [x for pair in pairs for x in pair if math.isfinite(x)] or [LEAST, 1.0]
    low, high = 10.0 ** math.floor(math.log10(0.5 * min(ends))), 10.0 ** math.ceil(math.log10(2.0 * max(ends)))
    ax.set(xscale="log", yscale="log", xlim=(low, high), ylim=(low, high), xlabel="true error, relative")
    ax.set(ylabel="error that the run claims, relative")
    ax.fill_between([low, high], [low, low], [low, high], color=LIMIT, zorder=0.5, linewidth=0.0)
    ax.plot([low, high], [low, high], color=DOUBT, linewidth=1.0, zorder=1.0)
    for label in study.methods:
        own = [pair for p, pair in zip(known, pairs, strict=True) if p.method == label]
        look = {**looks[label], "linestyle": "none"}
        ax.plot([x for x, _ in own], [y for _, y in own], markersize=6.5, zorder=3.0, **look)
    ax.text(0.98, 0.03, "claims too little", transform=ax.transAxes, ha="right", fontsize="small", color="#666666")
    ax.text(0.02, 0.95, "claims enough", transform=ax.transAxes, va="top", fontsize="small", color="#666666")
    ax.grid(True, which="major", linewidth=0.4, alpha=0.6)
    ax.set_title("claimed against true", fontsize="medium", loc="left")


def _milliseconds(point: WorkPoint) -> float:
    return 1e3 * point.wall_time


def _steps(point: WorkPoint) -> float:
    return float(point.steps) if point.steps else math.nan


def _shape(study: SceneStudy, output: str) -> _Measure:
    return _Measure(
        lambda point: point.errors.get(output, math.nan),
        lambda point: study.floor(point, output),
        lambda point: study.recorded(point, output),
        study.reference.error[output],
        study.reference.reach(output),
    )


def _timing(study: SceneStudy, output: str) -> _Measure:
    own = study.reference.at_equal_times.get(output, UNKNOWN).mean
    return _Measure(
        lambda point: point.at_equal_times.get(output, UNKNOWN).mean,
        lambda point: own + point.unseen_at_equal_times.get(output, 0.0),
        lambda point: point.unseen_at_equal_times.get(output, 0.0) > 0.5 * own,
        own,
        study.reference.reach_at_equal_times(output),
    )


def _range(study: SceneStudy, measure: _Measure) -> tuple[float, float]:
    """Lowest and highest error shown: whole decades about the finite ones and that of the reference."""
    values = [measure.value(point) for point in study.points if not point.failure]
    known = [min(value, 10.0) for value in (*values, measure.own) if 0.0 < value < math.inf]
    if not known:
        return 1e-6, 1.0
    low = max(min(known), LEAST)
    if 0.0 < measure.own < math.inf:
        low = max(low, 0.1 * measure.own)
    return 10.0 ** math.floor(math.log10(low)), 10.0 ** math.ceil(math.log10(1.01 * max(known)))


def _panel(ax: Axes, study: SceneStudy, measure: _Measure, looks: Any, abscissa: Callable[[WorkPoint], float]) -> None:
    bottom, top = _range(study, measure)
    failures = top * (top / bottom) ** 0.06  # where the crosses are
    ax.set(xscale="log", yscale="log", ylim=(bottom, top * (top / bottom) ** 0.12))
    if measure.own > bottom:
        ax.axhspan(bottom, measure.own, color=LIMIT, zorder=0.5, linewidth=0.0)
    if max(bottom, measure.own) < measure.reach < math.inf:
        ax.axhline(measure.reach, color=DOUBT, linewidth=1.0, linestyle="--", zorder=1.0)
    ax.axhline(top, color="#999999", linewidth=0.8, zorder=1.0)
    sound = [p for p in study.points if _is_sound(p, measure) and math.isfinite(abscissa(p))]
    front = _front([(abscissa(p), max(measure.value(p), _least(measure, p, bottom))) for p in sound])
    if len(front) > 1:
        ax.plot(*zip(*front, strict=True), color=FRONT, linewidth=9.0, zorder=1.5, solid_capstyle="round")
    for label in study.methods:
        _series(ax, [p for p in sound if p.method == label], measure, looks[label], abscissa, (bottom, top))
        failed = [abscissa(p) for p in study.points if p.method == label and p.failure and not p.refused]
        failed = [cost for cost in failed if math.isfinite(cost)]
        ax.plot(
            failed, [failures] * len(failed), linestyle="none", marker="x", color=looks[label]["color"],
            markersize=7.0, markeredgewidth=1.8, zorder=3.0,
        )  # fmt: skip
    ax.xaxis.set_minor_formatter(libs.NullFormatter())  # several of them do not fit into a panel
    ax.grid(True, which="major", linewidth=0.4, alpha=0.6)
    if any(p.failure and not p.refused for p in study.points):
        ax.text(
            0.995, 0.97 * top, "above: failed ", transform=ax.get_yaxis_transform(), ha="right", va="top",
            fontsize="x-small", color="#666666",
        )  # fmt: skip


def _series(
    ax: Axes, points: Sequence[WorkPoint], measure: _Measure, look: Any, abscissa: Any, limits: tuple[float, float]
) -> None:
    """One method: full markers, hollow ones below what is known, half full ones where the record is to blame."""
    bottom, top = limits
    x = [abscissa(p) for p in points]
    y = [min(max(measure.value(p), bottom * 1.15), top) for p in points]
    ax.plot(x, y, color=look["color"], linestyle=look["linestyle"], linewidth=1.4, zorder=2.0)
    unknown = [not measure.value(p) > measure.floor(p) for p in points]
    blurred = [empty and measure.recorded(p) for empty, p in zip(unknown, points, strict=True)]
    for style, chosen in (
        ("full", [k for k, empty in enumerate(unknown) if not empty]),
        ("none", [k for k, empty in enumerate(unknown) if empty and not blurred[k]]),
        ("bottom", [k for k, blur in enumerate(blurred) if blur]),
    ):
        ax.plot(
            [x[k] for k in chosen], [y[k] for k in chosen], linestyle="none", markersize=6.5, zorder=3.0,
            color=look["color"], marker=look["marker"], fillstyle=style, markerfacecoloralt="white",
        )  # fmt: skip


def _bars(ax: Axes, study: SceneStudy, output: str, looks: Any) -> None:
    """From the mean difference at equal times up to the largest."""
    low, high = ax.get_ylim()
    for point in study.points:
        found = point.at_equal_times.get(output, UNKNOWN)
        if not point.failure and math.isfinite(found.largest) and found.largest > low:
            ends = [max(found.mean, low), min(found.largest, high)]
            ax.plot([_milliseconds(point)] * 2, ends, color=looks[point.method]["color"], linewidth=0.8, alpha=0.6)


def _is_sound(point: WorkPoint, measure: _Measure) -> bool:
    return not point.failure and math.isfinite(measure.value(point))


def _least(measure: _Measure, point: WorkPoint, bottom: float) -> float:
    """The smallest error that may be claimed of a point."""
    floor = measure.floor(point)
    return max(floor, bottom) if math.isfinite(floor) else bottom


def _front(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Those that no other one beats in cost and error, by cost."""
    front: list[tuple[float, float]] = []
    for cost, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((cost, error))
    return front


def _legend(ax: Axes, study: SceneStudy, looks: Any, output: str, timed: bool) -> None:
    """Beside the panels of a scene: methods, signs, reference and what does not apply."""
    lines = [f"reference: {study.reference.source}", *(f"{label}: does not apply" for label in study.refusals)]
    title = "\n".join(textwrap.fill(line, 44, subsequent_indent="  ", max_lines=5) for line in lines)
    legend = ax.legend(
        handles=[*_methods(study, looks), *_signs(study, output, timed)], loc="upper left", bbox_to_anchor=(0.0, 1.0),
        borderaxespad=0.0, frameon=False, fontsize="small", title=title, title_fontsize="small", alignment="left",
    )  # fmt: skip
    legend.set_in_layout(False)  # its axes are wide enough; the panels shall not shrink for it


def _methods(study: SceneStudy, looks: Any) -> list[Any]:
    return [
        libs.Line2D([], [], label=textwrap.fill(label, WIDTH, max_lines=3), linewidth=1.4, **looks[label])
        for label in study.methods
    ]


def _signs(study: SceneStudy, output: str, timed: bool) -> list[Any]:
    grey: Any = {"color": "#666666", "linestyle": "none"}
    signs: list[Any] = [libs.Line2D([], [], color=FRONT, linewidth=9.0, label="best of all (Pareto)")]
    limited = [p for p in study.points if not p.failure and output in p.errors and study.limited(p, output)]
    if any(not study.recorded(p, output) for p in limited):
        signs.append(libs.Line2D([], [], marker="o", fillstyle="none", label="hollow: error too small to tell", **grey))
    if any(study.recorded(p, output) for p in limited):
        half = "half full: below the error of the record"
        signs.append(
            libs.Line2D([], [], marker="o", fillstyle="bottom", markerfacecoloralt="white", label=half, **grey)
        )
    if any(point.failure and not point.refused for point in study.points):
        signs.append(libs.Line2D([], [], marker="x", label="failed", **grey))
    if timed and study.reference.measured[output].parts:
        signs.append(libs.Line2D([], [], color="#666666", linewidth=0.8, label="at equal times: mean up to largest"))
    own, reach = study.reference.error[output], study.reference.reach(output)
    known = f"below the reference's error {own:.1e}" if np.isfinite(own) else "error of the reference: unknown"
    signs.append(libs.Patch(color=LIMIT, label=known))
    if not math.isnan(reach) and reach > own:
        doubt = "no independent method confirms any" if math.isinf(reach) else f"confirmed down to {reach:.1e}"
        signs.append(libs.Line2D([], [], color=DOUBT, linestyle="--", linewidth=1.0, label=doubt))
    return signs


_DRAWN = dict(zip(PANELS, (_errors, _at_equal_times, _against_steps, _claims), strict=True))
