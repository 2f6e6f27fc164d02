"""The picture of a study of fidelity: error against cost."""

from __future__ import annotations

import math
import textwrap
from typing import TYPE_CHECKING, Any

from lcpflex.basics import libs

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lcpflex.studies.model_order.report import FidelityRun, RightSize

__all__ = ["chart"]

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = "osD^vP"
GOOD = "#E3F1E3"
LEAST = 1e-8  # smallest error drawn
TURN = 35.0  # of names [degrees]
LETTER, LINE = 4.0, 8.0  # width and height of a letter [pt]


def chart(study: RightSize) -> Figure:
    """Estimated error of each output against wall time; the band holds what is within the tolerance."""
    figure = libs.Figure(figsize=(9.0, 5.2), layout="constrained")
    ax = figure.subplots()
    ax.set(
        xscale="log", yscale="log", xlabel="wall time of a run [ms]", ylabel="estimated error, relative to full mesh"
    )
    sound = [run for run in study.runs if run.errors and math.isfinite(run.estimate)]
    low, high = _range(study, sound)
    ceiling = high * (high / low) ** 0.1
    ax.set_ylim(low, ceiling)
    ax.axhspan(low, study.tolerance, color=GOOD, zorder=0.5, linewidth=0.0)
    ax.axhline(study.tolerance, color="#5B9A5B", linewidth=1.0, zorder=1.0)
    outputs = tuple(dict.fromkeys(name for run in sound for name in run.errors))
    for k, name in enumerate(outputs):
        style: Any = {"linestyle": "none", "markersize": 6.5, "color": COLOURS[k % len(COLOURS)], "zorder": 3.0}
        points = sorted((1e3 * run.wall_time, run.errors[name]) for run in sound if name in run.errors)
        drawn = [(x, y) for x, y in points if y >= low]
        ax.plot(
            *zip(*drawn or [(math.nan, math.nan)], strict=True), marker=MARKERS[k % len(MARKERS)], label=name, **style
        )
        for x in (x for x, y in points if y < low):  # none, or next to none: a logarithmic axis has no place for it
            ax.plot(x, low, marker="v", markerfacecolor="white", clip_on=False, **style)
    for run in study.runs:
        if run.failure and math.isfinite(run.wall_time):
            ax.plot(1e3 * run.wall_time, high, "x", color="#666666", markersize=8.0, markeredgewidth=1.8, zorder=3.0)
    if math.isfinite(study.full):
        known = "measured" if study.full_was_run else "predicted"
        ax.axvline(1e3 * study.full, color="#999999", linewidth=1.0, linestyle=":", label=f"full mesh, {known}")
    if any(run.failure for run in study.runs):
        ax.plot([], [], "x", color="#666666", label="failed")
    if any(error < low for run in sound for error in run.errors.values()):
        ax.plot([], [], "v", color="#666666", markerfacecolor="white", label="no error, by definition or in effect")
    left, right = ax.get_xlim()
    ax.set_xlim(left, right * (right / left) ** 0.1)  # room for the last label
    ax.grid(True, which="major", linewidth=0.4, alpha=0.6)
    ax.text(0.01, study.tolerance, f" tolerance {100.0 * study.tolerance:.2g} %", transform=ax.get_yaxis_transform(),
            va="bottom", fontsize="small", color="#3B7A3B")  # fmt: skip
    bodies = " / ".join(study.runs[0].levels)
    plus = ", free+residual" if any("+" in _short(level) for run in study.runs for level in run.levels.values()) else ""
    ax.legend(loc="upper right", fontsize="small", title=f"labels: modes of {bodies}{plus}", title_fontsize="small")
    for axis in (ax.xaxis.set_major_formatter, ax.xaxis.set_minor_formatter):
        axis(libs.LogFormatter(minor_thresholds=(2.0, 0.5)))
    ax.set_title("\n".join(_wrapped(study.sentence())), fontsize="medium", loc="left")
    figure.draw_without_rendering()  # lays out: names need their places
    _name(ax, study, sound, low)
    return figure


def _range(study: RightSize, sound: list[FidelityRun]) -> tuple[float, float]:
    values = [error for run in sound for error in run.errors.values() if LEAST < error < math.inf]
    known = [*values, study.tolerance]
    return 10.0 ** math.floor(math.log10(0.5 * min(known))), 10.0 ** math.ceil(math.log10(1.5 * max(known)))


def _name(ax: Axes, study: RightSize, sound: list[FidelityRun], low: float) -> None:
    """Levels over the worst error of each run, but where names would lie on each other; the chosen one is marked."""
    named: list[tuple[float, float, int]] = []
    for run in sorted(sound, key=lambda one: (not one.chosen, not one.full, one.coordinates)):
        at = (1e3 * run.wall_time, max(run.estimate, low))
        if run.chosen:
            ax.plot(*at, "o", markersize=17.0, markerfacecolor="none", markeredgecolor="#000000", zorder=4.0)
        text = " / ".join(_short(level) for level in run.levels.values())
        if _hidden(ax, at, text, named):
            continue
        ax.annotate(
            text, at, xytext=(3.0, 10.0 if run.chosen else 6.0),
            textcoords="offset points", fontsize="x-small", rotation=TURN, rotation_mode="anchor",
            fontweight="bold" if run.chosen else "normal",
        )  # fmt: skip


def _hidden(ax: Axes, at: tuple[float, float], text: str, named: list[tuple[float, float, int]]) -> bool:
    """Whether a name there would lie on one that is in ``named``; else it is added to it."""
    x, y = 72.0 / ax.figure.dpi * ax.transData.transform(at)  # [pt]
    cos, sin = math.cos(math.radians(TURN)), math.sin(math.radians(TURN))
    along, across = cos * x + sin * y, cos * y - sin * x
    for other, beside, length in named:
        ahead = length if along > other else len(text)
        if abs(across - beside) < LINE and abs(along - other) < ahead * LETTER:
            return True
    named.append((along, across, len(text)))
    return False


def _short(level: str) -> str:
    if " free and " in level:
        return level.removesuffix(" residual modes").replace(" free and ", "+")
    return level.removesuffix(" modes").removesuffix(" mode").removesuffix(" mesh")


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, 95)
